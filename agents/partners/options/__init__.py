"""A partner that chooses among options by a small learned network; a fixed controller carries them out."""
