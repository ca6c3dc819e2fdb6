"""Client connections: websocket endpoint, control messages, send queue, admission limits."""
