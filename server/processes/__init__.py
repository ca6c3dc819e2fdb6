"""Rooms in several processes behind one address."""
