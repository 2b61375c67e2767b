"""Access control of the router, derived from the topic table: who may publish, read and ask for what."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any, Final

from passafe_protocol.identity import ROUTER, Identity
from passafe_protocol.keys import KEY_ROOT, key_of
from passafe_protocol.topics import TOPICS, Topic

CACHE: Final = "@adv/**"
"""Below a topic's key: heartbeats and cache of its publisher, from which the recorder asks for what it missed."""

ADMISSION: Final = f"{KEY_ROOT}/@admission"
"""Prefix of the keys at which a router answers a holder that it admits; ``*`` and ``**`` do not match it."""

OPEN_KEY: Final = f"{ADMISSION}/anybody"
"""Key that no rule admits, so that an answer there shows that access control is not in force."""

_FORWARDED: Final = ["put", "declare_subscriber", "query", "declare_queryable", "reply"]
"""Messages that a router forwards; ``delete`` and liveliness are none that passafe has."""


def published_topics(role: str) -> list[Topic]:
    """Return the topics that a role may publish."""
    return [topic for topic in TOPICS if role in topic.publishers]


def admission_key(identity: Identity) -> str:
    """Return the key at which the router answers this holder and no other."""
    return f"{ADMISSION}/{identity.common_name}"


def access_control(admitted: Iterable[Identity]) -> dict[str, Any]:
    """Return the access control of a router, as Zenoh's configuration has it.

    A session may do what a rule for its certificate's common name allows, and nothing else. Messages are checked where
    they enter the router and where they leave it; common names are compared literally. Rules cannot change while the
    router runs.

    A process publishes the rows of the topic table that name its role, for its robot, under exactly these keys, and
    reads every topic of its robot. Linked routers pass on what their own access control let in.

    Args:
        admitted: Holders of certificates that the router lets in.
    """
    rules: dict[str, dict[str, Any]] = {}
    names: defaultdict[str, list[str]] = defaultdict(list)
    policies: list[dict[str, Any]] = []
    everyone = sorted(set(admitted))
    for identity in everyone:
        group = identity.role if identity.role == ROUTER else f"{identity.role}.{identity.robot}"
        names[group].append(identity.common_name)
        if len(names[group]) == 1:
            made = _router_rules() if identity.role == ROUTER else _role_rules(identity.role, identity.robot)
            of_group = [rule | {"id": f"{group} {rule['id']}"} for rule in made]
            rules |= {rule["id"]: rule for rule in of_group}
            policies.append({"rules": [rule["id"] for rule in of_group], "subjects": [group]})
        key = [admission_key(identity)]
        ask = _rule(f"{identity.common_name} asks", ["query"], key)
        receive = _rule(f"{identity.common_name} is answered", ["reply"], key, flow="egress")
        rules |= {ask["id"]: ask, receive["id"]: receive}
        policies.append({"rules": [ask["id"], receive["id"]], "subjects": [_alone(identity)]})
    subjects = [_subject(group, common_names) for group, common_names in names.items()]
    subjects += [_subject(_alone(each), [each.common_name]) for each in everyone]
    return {
        "enabled": True,  # rules without it are ignored
        "default_permission": "deny",
        "rules": list(rules.values()),
        "subjects": subjects,
        "policies": policies,
    }


def _alone(identity: Identity) -> str:
    return f"{identity.common_name} alone"


def _subject(name: str, common_names: list[str]) -> Mapping[str, Any]:
    """Return a subject without interfaces: an empty list of them would match nothing, without a word."""
    return {"id": name, "cert_common_names": common_names}


def _rule(name: str, messages: list[str], keys: list[str], *, flow: str = "ingress") -> dict[str, Any]:
    return {"id": name, "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": keys}


def _role_rules(role: str, robot: str) -> list[dict[str, Any]]:
    """Return what a role of a robot may do."""
    keys = [topic.key(role, robot) for topic in published_topics(role)]
    caches = [f"{key}/{CACHE}" for key in keys]
    all_keys = key_of(robot, "*", "*")
    rules = [
        _rule("read", ["declare_subscriber"], [all_keys, f"{all_keys}/{CACHE}"]),
        _rule("receive", _FORWARDED, [all_keys, f"{all_keys}/{CACHE}"], flow="egress"),
    ]
    if keys:  # a rule without keys is refused
        rules += [
            _rule("publish", ["put"], [*keys, *caches]),
            _rule("answer", ["declare_queryable", "reply"], caches),
            _rule("answer with", ["reply"], keys),
        ]
    if role == "recorder":
        rules.append(_rule("recover", ["query"], [f"{all_keys}/{CACHE}"]))
    return rules


def _router_rules() -> list[dict[str, Any]]:
    """Return what a linked router may pass on: its own access control has checked it."""
    keys = [key_of("*", "*", "*"), f"{key_of('*', '*', '*')}/{CACHE}"]
    return [_rule("pass on", _FORWARDED, keys), _rule("be passed on", _FORWARDED, keys, flow="egress")]
