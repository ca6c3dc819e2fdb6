"""Placement: where in the goals items are put down."""
