"""Where in the goal regions items go."""
