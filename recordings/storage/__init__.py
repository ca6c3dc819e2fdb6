"""Recordings in a folder: finishing, repairing, listing."""
