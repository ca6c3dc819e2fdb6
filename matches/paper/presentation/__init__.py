"""How what was measured is shown: laid out as the paper does, as Markdown, LaTeX, HTML, charts and pictures."""
