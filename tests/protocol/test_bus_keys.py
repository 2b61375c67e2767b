"""Key expressions name robot, process and topic."""

import pytest
from passafe_protocol.errors import RobotNameError
from passafe_protocol.keys import KeyParts, key_of, parts_of, require_robot_name


def test_parts_of_a_key_are_those_it_was_made_of() -> None:
    assert parts_of(key_of("left-arm", "plant", "state")) == KeyParts("left-arm", "plant", "state")


def test_a_key_of_an_older_log_names_no_robot() -> None:
    assert parts_of("passafe/filter/tick") == KeyParts("", "filter", "tick")


@pytest.mark.parametrize("key", ["", "passafe", "passafe/state", "passafe/a/b/c/d", "other/a/b/c", "other/b/c"])
def test_other_keys_have_no_parts(key: str) -> None:
    assert parts_of(key) is None


@pytest.mark.parametrize("name", ["robot", "a", "7", "arm_2", "left-arm", "a" * 32])
def test_names_that_a_robot_may_have(name: str) -> None:
    assert require_robot_name(name) == name


@pytest.mark.parametrize("name", ["", "*", "**", "a/b", "@adv", "A", "-a", "a b", "a.b", "é", "a" * 33, "a\n"])
def test_names_that_no_robot_may_have(name: str) -> None:
    with pytest.raises(RobotNameError, match=r"robot: got .* allowed 1 to 32"):
        require_robot_name(name)
