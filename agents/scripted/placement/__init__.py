"""Placement: where in the goal regions items are put down."""
