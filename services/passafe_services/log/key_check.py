"""Check that the keys of a log are those of one robot, and of the processes whose messages are under them."""

from collections.abc import Collection, Iterable, Mapping

from passafe_protocol.keys import parts_of
from passafe_protocol.topics import TOPIC_OF_NAME


def key_shortcomings(keys: Iterable[str], sources: Mapping[str, Collection[str]]) -> list[str]:
    """Return in words what keys and the senders of messages have against each other.

    Args:
        keys: Key expressions of the channels.
        sources: Processes that sent messages, by name of the topic.
    """
    known = [parts for key in keys if (parts := parts_of(key)) is not None and parts.topic in TOPIC_OF_NAME]
    robots = sorted({parts.robot for parts in known})
    found = [f"keys of {len(robots)} robots: {', '.join(robots)}"] if len(robots) > 1 else []
    for topic, senders in sources.items():
        others = sorted({*senders} - {parts.source for parts in known if parts.topic == topic})
        found += [f"{topic}: messages of {name} under the key of another" for name in others]
    return found
