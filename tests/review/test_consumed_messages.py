"""Messages that ticks consumed: which were sent, and which the filter may have left out."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
from passafe_services.log.message_block import MessageBlock
from passafe_services.tools.review.consumed_messages import LoggedMessages

MS = 1_000_000


def block(sequence: list[int], plant_ms: list[int]) -> MessageBlock:
    columns = {"plant_ns": np.array(plant_ms) * MS}
    made: Any = SimpleNamespace(epoch=7, sequence=np.array(sequence), numbers=columns.__getitem__)
    return cast("MessageBlock", made)


def test_states_after_a_leap_of_plant_time_may_be_left_out() -> None:
    """0.4 s after one of 4 ms: of a state 0.1 s is believed, and the fifth follows again."""
    states = LoggedMessages(("plant_ns",))
    states.add(block([0, 1, 2, 3, 4, 5, 6, 7], [0, 4, 404, 408, 412, 416, 420, 424]))

    certain = states.follow(7, np.arange(8), "plant_ns", 100 * MS)
    assert certain.tolist() == [True, True, False, False, False, False, True, True]


def test_states_behind_a_loss_follow() -> None:
    states = LoggedMessages(("plant_ns",))
    states.add(block([0, 1, 9], [0, 4, 404]))

    assert states.follow(7, np.array([9]), "plant_ns", 100 * MS).all()
    assert not states.follow(8, np.array([9]), "plant_ns", 100 * MS).any()
