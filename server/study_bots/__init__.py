"""Simulated participants: they go through a whole study over the interfaces that browsers use, and log what they do."""
