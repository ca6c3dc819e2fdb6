"""The results of a study: one offline page and tables, made from its store."""
