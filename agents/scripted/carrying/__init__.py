"""Driving what is held: alone, and by two."""
