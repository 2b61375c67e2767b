"""Prints the digests of decisions of several scenarios and of a drawn design, as JSON by name."""

import hashlib
import json
import sys
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from passafe_protocol.codec import encode
from passafe_protocol.messages import Header, Message
from passafe_protocol.topics import Topic
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop
from passafe_services.tools.generated.generated_design import GeneratedDesign

from passafe import SafetyPassivityFilter

SCENARIOS: Final[Mapping[str, tuple[int, Mapping[str, Any]]]] = {
    "notomista-cai-2020": (400, {}),
    "two-robots": (200, {}),
    "wrong-mass": (200, {}),
    "tight-limits": (500, {}),
    "human-steers": (200, {}),
    "lagged-point": (400, {}),
    "moving-disk": (200, {}),
    "unicycle-posts": (60, {"filter.gatekeeper": True}),
    "arm-over-table": (12, {}),
}
"""Periods and changes, by name."""

DESIGN: Final = 5
"""Seed of a bicycle."""

STATES: Final = 40


def of_scenario(name: str) -> str:
    """Return the digest of everything that a loop in virtual time sends."""
    periods, changes = SCENARIOS[name]
    digest = hashlib.sha256()

    def take(topic: Topic, header: Header, body: Message) -> None:
        digest.update(topic.name.encode() + encode(header, body))

    loop = lockstep_loop(load_scenario(name, changes), take)
    loop.run(periods)
    loop.finish()
    return digest.hexdigest()


def of_drawn_design() -> str:
    """Return the digest of a gatekeeper's decisions at states and requests drawn from a box, most of them hopeless."""
    design = GeneratedDesign.of(DESIGN)
    core = SafetyPassivityFilter(design.filter_design(gatekeeper=True))
    rng, m, bound = np.random.default_rng(1), design.plant.system.m, np.array(design.limits.magnitude)
    digest = hashlib.sha256()
    for x in rng.uniform(design.plant.low, design.plant.high, (STATES, design.plant.system.n)):
        u_h = 2 * rng.uniform(-bound, bound)
        decision = core.decide(x.tolist(), [0.0] * m, u_h.tolist(), [0.0] * m, 1.0, start=True)
        digest.update(decision.status.name.encode() + decision.block.tobytes())
    return digest.hexdigest()


def main() -> None:
    """Print them."""
    json.dump({name: of_scenario(name) for name in SCENARIOS} | {"drawn design": of_drawn_design()}, sys.stdout)


if __name__ == "__main__":
    main()
