"""Access control follows from the topic table."""

from typing import Any

import pytest
from passafe_protocol.identity import ROLES, Identity
from passafe_protocol.topics import TOPICS
from passafe_services.keys.deployment import identities_of
from passafe_services.loop.access import OPEN_KEY, access_control


def allowed(control: dict[str, Any], common_name: str, message: str, flow: str = "ingress") -> set[str]:
    """Return the keys for which a holder may send a message."""
    subjects = {one["id"] for one in control["subjects"] if common_name in one["cert_common_names"]}
    rules = {rule for policy in control["policies"] if subjects & {*policy["subjects"]} for rule in policy["rules"]}
    found = [rule for rule in control["rules"] if rule["id"] in rules and rule["flows"] == [flow]]
    return {key for rule in found if message in rule["messages"] for key in rule["key_exprs"]}


@pytest.fixture
def control() -> dict[str, Any]:
    return access_control(identities_of(["left", "right"], ["alice"]))


@pytest.mark.parametrize("role", ROLES)
def test_a_role_may_publish_its_rows_of_the_table_alone(control: dict[str, Any], role: str) -> None:
    keys = {topic.key(role, "left") for topic in TOPICS if role in topic.publishers}

    assert allowed(control, f"{role}.left", "put") == keys | {f"{key}/@adv/**" for key in keys}
    assert not any("*" in key.removesuffix("/@adv/**") for key in allowed(control, f"{role}.left", "put"))
    assert allowed(control, f"{role}.left", "delete") == set()


def test_the_recorder_alone_asks_the_caches(control: dict[str, Any]) -> None:
    for role in ROLES:
        asked = allowed(control, f"{role}.left", "query") - {f"passafe/@admission/{role}.left"}
        assert asked == ({"passafe/left/*/*/@adv/**"} if role == "recorder" else set())


def test_a_named_operator_has_the_rights_of_its_role(control: dict[str, Any]) -> None:
    for message in ("put", "reply", "declare_subscriber", "declare_queryable"):
        assert allowed(control, "operator.left.alice", message) == allowed(control, "operator.left", message)
    assert allowed(control, "operator.left.alice", "query") == {"passafe/@admission/operator.left.alice"}


def test_robots_have_no_key_in_common(control: dict[str, Any]) -> None:
    for flow in ("ingress", "egress"):
        for message in ("put", "query", "reply", "declare_subscriber", "declare_queryable"):
            for role in ROLES:
                keys = allowed(control, f"{role}.left", message, flow)
                assert all(key.startswith(("passafe/left/", "passafe/@admission/")) for key in keys)


def test_rules_are_enabled_and_deny_by_default(control: dict[str, Any]) -> None:
    assert control["enabled"] is True
    assert control["default_permission"] == "deny"
    assert {rule["permission"] for rule in control["rules"]} == {"allow"}


def test_no_subject_has_a_list_of_interfaces(control: dict[str, Any]) -> None:
    assert all({*subject} == {"id", "cert_common_names"} for subject in control["subjects"])
    assert all(subject["cert_common_names"] for subject in control["subjects"])


def test_every_rule_id_and_subject_id_is_there_once(control: dict[str, Any]) -> None:
    for part in ("rules", "subjects"):
        names = [one["id"] for one in control[part]]
        assert len(names) == len({*names})
    assert {rule for policy in control["policies"] for rule in policy["rules"]} == {
        rule["id"] for rule in control["rules"]
    }


def test_nobody_is_admitted_where_everybody_would_be(control: dict[str, Any]) -> None:
    assert all(OPEN_KEY not in rule["key_exprs"] for rule in control["rules"])


def test_only_routers_pass_on_what_others_sent() -> None:
    control = access_control([Identity(role="router", name="site-b"), Identity(role="filter", robot="arm")])

    assert "passafe/*/*/*" in allowed(control, "router.site-b", "put")
    assert "passafe/*/*/*" not in allowed(control, "filter.arm", "put")
