"""Logs that were written anew without some messages, with others among them, or under other keys."""

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from changed_logs import Recorded, loaded, metadata_of, recorded, verdict_on
from msgspec.structs import replace
from passafe_protocol.codec import encode
from passafe_protocol.messages import (
    FilterTick,
    Header,
    LinkState,
    Message,
    OperatorLease,
    PlantInput,
    PlantState,
    ScenarioInfo,
)
from passafe_protocol.topics import TOPIC_OF_BODY
from passafe_services.log.log_writer import LogWriter

Sent = tuple[Header, Message]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    scenario = loaded("notomista-cai-2020", {"links.plant-to-filter": {"loss": 0.1}})
    return Recorded(scenario, recorded(tmp_path_factory.mktemp("log") / "run.mcap", scenario, 300))


def written(run: Recorded, messages: Sequence[Sent], path: Path, key: Callable[[str], str] = str) -> Path:
    with LogWriter(path, metadata_of(run.scenario)) as log:
        for header, body in messages:
            name = key(TOPIC_OF_BODY[type(body)].key(header.source))
            log.write(name, encode(header, body), sequence=header.sequence, wall_ns=5)
    return path


@pytest.mark.parametrize(
    ("kind", "part", "said"),
    [
        (FilterTick, slice(0, 1), "not complete"),
        (FilterTick, slice(100, 101), "not complete"),
        (FilterTick, slice(-1, None), "the log has no such tick"),
        (PlantInput, slice(0, 1), "not complete"),
        (ScenarioInfo, slice(None), "no configuration of the filter"),
        (LinkState, slice(None), "links-reconciled is unknown"),
        (LinkState, slice(-1, None), "not links-reconciled"),
        (OperatorLease, slice(0, 1), "not complete"),
    ],
)
def test_what_is_left_out_is_said(run: Recorded, kind: type[Message], part: slice, said: str, tmp_path: Path) -> None:
    places = [place for place, (_, body) in enumerate(run.messages) if type(body) is kind]
    left = {*places[part]}
    verdict = verdict_on(
        written(run, [each for place, each in enumerate(run.messages) if place not in left], tmp_path / "run.mcap")
    )

    assert left
    assert said in verdict.words
    assert verdict.verdict != "holds"


@pytest.mark.parametrize("distance", [1, 5_000])
def test_a_second_message_of_a_number_is_counted(run: Recorded, distance: int, tmp_path: Path) -> None:
    place = next(
        n for n, (header, body) in enumerate(run.messages) if type(body) is PlantState and header.sequence == 99
    )
    header, body = run.messages[place]
    other = header, replace(body, x=(9.0,) * len(body.x))
    messages = [*run.messages]
    messages.insert(place + distance, other)
    verdict = verdict_on(written(run, messages, tmp_path / "run.mcap"))

    assert verdict.verdict == "unproven"
    assert "1 messages have the number of another one" in verdict.words


def test_a_copy_of_a_message_is_none_of_another(run: Recorded, tmp_path: Path) -> None:
    messages = [each for each in run.messages for _ in range(2)]

    assert verdict_on(written(run, messages, tmp_path / "run.mcap")).verdict == "holds"


@pytest.mark.parametrize(
    ("key", "said"),
    [
        (lambda key: key.replace("/robot/plant", "/arm/plant"), "keys of 2 robots: arm, robot"),
        (lambda key: key.replace("/plant/state", "/filter/state"), "state: messages of plant under the key of another"),
    ],
)
def test_messages_under_other_keys(run: Recorded, key: Callable[[str], str], said: str, tmp_path: Path) -> None:
    verdict = verdict_on(written(run, run.messages, tmp_path / "run.mcap", key))

    assert verdict.verdict == "unproven"
    assert said in verdict.words
