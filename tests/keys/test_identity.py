"""Identities and their common names."""

import pytest
from passafe_protocol.errors import IdentityError, RobotNameError
from passafe_protocol.identity import ROLES, ROUTER, Identity
from passafe_protocol.topics import READERS, TOPICS


def test_roles_are_the_publishers_of_the_topic_table() -> None:
    assert {*ROLES, ROUTER} == {role for topic in TOPICS for role in topic.publishers} | {*READERS}


@pytest.mark.parametrize(
    ("identity", "common_name"),
    [
        (Identity(role="filter", robot="left-arm"), "filter.left-arm"),
        (Identity(role="operator", robot="left-arm", name="alice"), "operator.left-arm.alice"),
        (Identity(role="router"), "router"),
        (Identity(role="router", name="site-b"), "router.site-b"),
        (Identity(role="plant", robot="router"), "plant.router"),
    ],
)
def test_common_name_leads_back_to_its_identity(identity: Identity, common_name: str) -> None:
    assert identity.common_name == common_name
    assert Identity.of(common_name) == identity


@pytest.mark.parametrize(
    "text",
    ["", "filter.a.b.c", "filter.a.", "pilot.a", "operator.a.*", "router.A", "Filter.a", " filter.a", "filter.*"],
)
def test_other_names_are_nobody(text: str) -> None:
    with pytest.raises((IdentityError, RobotNameError)):
        Identity.of(text)


def test_a_process_without_robot_is_refused() -> None:
    with pytest.raises(RobotNameError):
        Identity(role="plant")
    with pytest.raises(IdentityError, match=r"robot of a router: got 'x', allowed none"):
        Identity(role="router", robot="x")
