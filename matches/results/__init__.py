"""Results: the folder, tables, tests of significance."""
