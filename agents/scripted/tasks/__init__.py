"""The tasks of a scripted agent."""
