"""The study file: what a study consists of, and who plays what with whom."""
