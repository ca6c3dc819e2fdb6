"""What docs/results.md is made of: the log of evaluation episodes, tables, a chart, and the page itself."""
