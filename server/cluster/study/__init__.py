"""A study over several nodes: one runs it, and all have rooms of it."""
