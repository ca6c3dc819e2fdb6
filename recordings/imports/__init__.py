"""Trajectories of the official project as recordings of ours, each with a report on how far it can be trusted."""
