"""Simulated participants: they take a whole study through the interfaces that browsers use, and keep a log of it."""
