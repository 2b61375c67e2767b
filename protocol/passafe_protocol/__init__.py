"""What crosses the wire: messages, the topic table, codec with validation, injected links."""
