"""Imports trajectories of the official project as recordings, each with a report on how far it can be trusted."""
