"""The data of a study: folder, export, erasure."""
