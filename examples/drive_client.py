"""Drive the robot of a running demo through its page's server: `python examples/drive_client.py [HOST:PORT]`."""

import json
import sys
import time

from websockets.sync.client import connect

RIGHT, HELD_S = [1.0, 0.0], 2.0


def main(host: str) -> None:
    """Take the wheel, push to the right for a while, give the wheel back."""
    with connect(f"ws://{host}/drive") as page:
        page.send(json.dumps({"type": "take", "over": False}))
        server_ms, arrived_s, until_s, number = None, 0.0, None, 0
        while until_s is None or time.monotonic() < until_s:
            try:
                message = json.loads(page.recv(timeout=1 / 60))
            except TimeoutError:
                message = {"type": "nothing new"}
            if message["type"] == "clock":
                server_ms, arrived_s = message["server_ms"], time.monotonic()
            elif message["type"] == "driver":
                print("I drive" if message["you"] else f"I do not drive. {message['reason']}")
                until_s = until_s or (time.monotonic() + HELD_S if message["you"] else None)
            elif message["type"] == "refused":
                raise SystemExit(f"{message['what']}: got {message['got']}, allowed {message['allowed']}")
            if until_s is not None and server_ms is not None:
                held_ms = (time.monotonic() - arrived_s) * 1e3
                steer = {"number": number, "shares": RIGHT, "engaged": True, "echo_ms": server_ms, "held_ms": held_ms}
                page.send(json.dumps({"type": "steer"} | steer))
                number += 1
        page.send(json.dumps({"type": "release"}))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1:8080")
