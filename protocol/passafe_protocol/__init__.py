"""Messages, the topic table, the codec with validation, and injected links."""
