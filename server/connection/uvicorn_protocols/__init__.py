"""Uvicorn's HTTP and websocket protocols with deadlines, limits on sizes and counts, and dropping a connection."""
