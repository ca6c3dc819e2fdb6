"""Trained agents at play, without torch."""
