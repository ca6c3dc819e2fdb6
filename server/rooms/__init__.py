"""Rooms: seats, rounds, pauses, and the scheduler that ticks them all."""
