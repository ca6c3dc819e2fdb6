"""Results for readers: compared with the paper, cross-play, Parquet."""
