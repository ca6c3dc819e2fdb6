"""What is to be played: grids, protocols, and the figures of the paper."""
