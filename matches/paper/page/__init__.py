"""The page with a row for every label of the paper, written from what folders have measured."""
