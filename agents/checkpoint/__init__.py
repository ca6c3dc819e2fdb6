"""Trained agents on disk."""
