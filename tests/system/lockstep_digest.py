"""Prints what a few loops in virtual time send, as one number, and where the modules that are named come from."""

import hashlib
import json
import sys
from importlib import import_module

from passafe_protocol.codec import encode
from passafe_protocol.messages import Header, Message
from passafe_protocol.topics import Topic
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop

LINKS = {  # each by another of a link's ways through
    "links.operator-to-filter": {"delay_s": 0.05},
    "links.plant-to-filter": {"delay_s": 0.05, "jitter_s": 0.01, "loss": 0.1},
    "links.filter-to-plant": {"delay_s": 0.05, "jitter_s": 0.01, "loss": 0.1, "duplicate": 0.01, "corrupt": 0.01},
}


def main() -> None:
    """Print it as JSON."""
    digest = hashlib.sha256()

    def take(topic: Topic, header: Header, body: Message) -> None:
        digest.update(topic.name.encode() + encode(header, body))

    for name in ("notomista-cai-2020", "walls-and-disks", "human-steers", "lagged-point"):
        for prediction in (True, False):
            overrides = {"rate_hz": 500.0, "filter.prediction": prediction} | LINKS
            loop = lockstep_loop(load_scenario(name, overrides), take)
            loop.run(1500)
            loop.finish()
    origins = {module: import_module(module).__file__ for module in sys.argv[1:]}
    json.dump({"digest": digest.hexdigest(), "origins": origins}, sys.stdout)


if __name__ == "__main__":
    main()
