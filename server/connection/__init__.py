"""One client: the websocket from handshake to goodbye, what it may ask, and what waits to be sent to it."""
