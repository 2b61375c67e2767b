"""The topic table is consistent and covers every message."""

from typing import get_args

import pytest
from passafe_protocol.messages import Message
from passafe_protocol.topics import (
    CLEAR,
    EVENT,
    HEALTH,
    INPUT,
    LINK_EVENT,
    LINK_STATE,
    LINKS,
    PROCESSES,
    STATE,
    STOP,
    TOPIC_OF_BODY,
    TOPIC_OF_NAME,
    TOPICS,
    Priority,
    Topic,
)


def test_each_message_type_has_exactly_one_topic() -> None:
    assert sorted(topic.body.__name__ for topic in TOPICS) == sorted(t.__name__ for t in get_args(Message))
    assert len(TOPIC_OF_BODY) == len(TOPIC_OF_NAME) == len(TOPICS)


def test_key_names_publisher_and_topic() -> None:
    assert INPUT.key("filter") == "passafe/robot/filter/input"
    assert INPUT.key("filter", "left-arm") == "passafe/left-arm/filter/input"
    assert HEALTH.key("router") == "passafe/robot/router/health"


def test_selector_of_one_publisher_is_its_key() -> None:
    assert STATE.selector() == STATE.key("plant")


def test_selector_of_several_publishers_takes_any() -> None:
    assert EVENT.selector("arm") == "passafe/arm/*/event"


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)
def test_row_is_consistent(topic: Topic) -> None:
    assert topic.publishers
    assert topic.queue > 0
    assert set(topic.links) <= set(PROCESSES) - set(topic.publishers)


def test_the_stop_has_a_priority_of_its_own() -> None:
    assert [topic.name for topic in TOPICS if topic.priority is Priority.REAL_TIME] == ["stop"]
    assert not STOP.links  # nobody who may change links can delay it
    assert set(CLEAR.publishers) < set(STOP.publishers)


def test_who_reads_through_a_link_may_tell_of_it() -> None:
    readers = {place.reader for place in LINKS.values()}

    assert readers <= set(LINK_EVENT.publishers)
    assert readers <= set(LINK_STATE.publishers)


def test_links_lead_to_their_topics() -> None:
    assert {name: (place.topic.name, place.reader) for name, place in LINKS.items()} == {
        "operator-to-filter": ("command", "filter"),
        "filter-to-plant": ("input", "plant"),
        "plant-to-filter": ("state", "filter"),
        "plant-to-operator": ("state", "operator"),
    }
    assert len(LINKS) == sum(len(topic.links) for topic in TOPICS)
