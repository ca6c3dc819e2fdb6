"""Reinforcement learning on top of imitation: a best response to partners, held near the imitated policy."""
