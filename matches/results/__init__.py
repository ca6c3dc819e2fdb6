"""What came of it: the results folder, tables, estimates."""
