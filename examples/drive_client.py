"""Drive the robot of a running demo through its page's server: ``python examples/drive_client.py [HOST:PORT]``."""

import json
import sys
import time

from websockets.sync.client import connect

PUSH, HELD_S = [1.0, 0.0], 2.0  # share of the authority of each input, from -1 to 1; for how long


def main(host: str) -> None:
    """Take the wheel, push to the right with the dead-man held, give the wheel back."""
    with connect(f"ws://{host}/drive") as page:
        page.send(json.dumps({"type": "take", "over": False}))
        ends_s, number = None, 0
        for message in map(json.loads, page):
            if message["type"] == "driver" and message["you"]:
                print("I drive")
                ends_s = time.monotonic() + HELD_S
            elif message["type"] in ("driver", "refused") and (message.get("reason") or message.get("what")):
                raise SystemExit(f"I do not drive: {message}")  # somebody else does, or a message was wrong
            elif message["type"] == "clock" and ends_s is not None:  # 20 a second; a command drives for 250 ms
                if time.monotonic() > ends_s:
                    break
                number += 1  # the echo of the clock says how old the command is
                echo = {"echo_ms": message["server_ms"], "held_ms": 0.0}
                page.send(json.dumps({"type": "steer", "number": number, "shares": PUSH, "engaged": True} | echo))
        page.send(json.dumps({"type": "release"}))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1:8080")
