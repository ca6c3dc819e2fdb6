"""The web interface of a study: pages, routes and event streams."""
