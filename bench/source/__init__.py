"""Readers of our own source code, for `bench.house`."""
