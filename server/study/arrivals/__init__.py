"""Who opens a page of a study: links, signatures, tokens, and which browser may come back."""
