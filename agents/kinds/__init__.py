"""The kinds of agents that can be trained: one record each."""
