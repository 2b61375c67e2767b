"""Bridge: shows a running system in Foxglove and Lichtblick, over a WebSocket."""
