"""Labels of the paper that are measured in another game."""
