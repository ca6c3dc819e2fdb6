"""The tables and figures of the paper: its numbers, what each needs here, and how both are laid out side by side."""
