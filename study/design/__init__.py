"""The study file: what a study is, and who plays what with whom."""
