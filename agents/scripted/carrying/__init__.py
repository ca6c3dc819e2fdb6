"""Carrying items: alone, and with the partner."""
