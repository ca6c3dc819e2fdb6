"""Agents to compare with: idle, recorded, delayed."""
