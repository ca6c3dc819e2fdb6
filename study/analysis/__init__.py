"""The results of a study: from its store to one offline page and tables."""
