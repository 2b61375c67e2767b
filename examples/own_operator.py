"""Drive the robot with a program of your own: a node on the bus that pushes in a circle.

Start ``passafe demo --headless`` in one terminal and ``python examples/own_operator.py`` in another. One operator at a
time holds the filter's lease, so this node asks to take over; the filter decides what the robot does with its commands.
"""

import argparse
from collections.abc import Sequence
from math import cos, sin, tau

from passafe_protocol.messages import OperatorCommand, OperatorLease, PlantState, Received
from passafe_protocol.topics import COMMAND, LEASE, STATE, Topic
from passafe_services.loop.live import run_live
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.node import Outgoing

STRENGTH, TURNS_PER_S = 8.0, 0.25  # size of the push, in units of the plant's input


class CirclingOperator:
    """A node: a name, the topics it reads, and a step. It has no clock and no socket, so tests can step it, too."""

    name = "operator"  # the topic table lets this process publish commands
    subscribes: tuple[Topic, ...] = (STATE, LEASE)
    position: tuple[float, ...] | None = None  # of the robot, once a state arrived
    take_over = 0  # number of the lease that another operator holds; a later one it leaves alone

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Return one command; called at a fixed rate with the messages that arrived since the step before."""
        for message in inbox:
            if isinstance(message.body, PlantState):
                self.position = message.body.x[:2]
            elif isinstance(message.body, OperatorLease):
                self.take_over = self.take_over or message.body.number
        angle, rate = tau * TURNS_PER_S * now_ns / 1e9, tau * TURNS_PER_S
        u_h = (STRENGTH * cos(angle), STRENGTH * sin(angle))
        u_h_rate = (-rate * u_h[1], rate * u_h[0])
        return [(COMMAND, OperatorCommand(u_h, u_h_rate, enabled=True, device="circle", take_over=self.take_over))]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Push the robot of a running demo in a circle.")
    parser.add_argument("--port", type=int, default=7447, help="port of the router")
    parser.add_argument("--duration", type=float, default=10.0, help="seconds to drive")
    options = parser.parse_args()
    node = CirclingOperator()
    # The live driver: connects to the router with the demo's keys for an operator, steps the node 100 times a second,
    # and publishes what it returns.
    endpoint = RouterEndpoint.of_demo(options.port, "operator")
    report = run_live(node, rate_hz=100.0, endpoint=endpoint, links={}, duration_s=options.duration)
    print(f"{report.steps} steps; the robot was last seen at {node.position}")
