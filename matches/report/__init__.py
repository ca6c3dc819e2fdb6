"""Results for people: beside the paper, cross-play, Parquet."""
