"""Answer HTTP and WebSocket requests: the live page, its state, the links."""
