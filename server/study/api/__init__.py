"""The web interface of a study: its pages, routes and streams of events."""
