"""The documentation site: pages that are generated, and what mkdocs changes in those of docs/."""
