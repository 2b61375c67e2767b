"""Zenoh sessions: the settings that router and processes share, and how a session is opened."""

import json
from collections.abc import Mapping
from typing import Final

import zenoh
from passafe_protocol.codec import MAX_MESSAGE_BYTES

from passafe_services.keys.credentials import Credentials
from passafe_services.loop.errors import BusError

LEASE_MS: Final = 500
"""Silence after which a session is closed: messages queued for it are dropped rather than delivered late."""

SHARED_SETTINGS: Final[dict[str, object]] = {
    "scouting/multicast/enabled": False,
    "scouting/gossip/enabled": False,
    "timestamping/enabled": False,
    "transport/shared_memory/enabled": False,
    "transport/link/tx/lease": LEASE_MS,
    # Bytes that a reader puts together from fragments: a larger message is refused before it takes memory.
    "transport/link/rx/max_message_size": 2 * MAX_MESSAGE_BYTES,
    # Batches of 64 KiB. A message that does not fit at once is dropped, and the first tick of a filter that waited for
    # its plant lists every command since its start, some 30 B each.
    "transport/link/tx/queue/size/data": 16,
    # µs. A full queue means that the peer is stalled; a control loop must not stall with it.
    "transport/link/tx/queue/congestion_control/drop/wait_before_drop": 0,
    "transport/link/tx/queue/congestion_control/block/wait_before_close": 500_000,
}
"""Settings of every session, router and processes alike."""

RETRY: Final = {"period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 2}
"""How a session that lost its router tries again."""


def client_settings(locator: str, credentials: Credentials | None, timeout_s: float) -> dict[str, object]:
    """Return the settings of a session with a router."""
    return (
        SHARED_SETTINGS
        | _tls_settings(credentials, listens=False)
        | {
            "mode": "client",
            "connect/endpoints": [locator],
            "connect/timeout_ms": round(1e3 * timeout_s),
            "connect/retry": RETRY,
        }
    )


def router_settings(locator: str, credentials: Credentials | None, linked: list[str]) -> dict[str, object]:
    """Return the settings of a router, without access control.

    Args:
        locator: Where it listens.
        credentials: Its keys; ``None``: without TLS.
        linked: Locators of the routers that it connects to, and connects to again whenever they are lost.
    """
    return (
        SHARED_SETTINGS
        | _tls_settings(credentials, listens=True)
        | {
            "mode": "router",
            "listen/endpoints": [locator],
            "adminspace/enabled": False,
            "connect/endpoints": linked,
            "connect/timeout_ms": -1,
            "connect/exit_on_failure": False,
            "connect/retry": RETRY,
        }
    )


def open_session(settings: Mapping[str, object]) -> zenoh.Session:
    """Open a session.

    Raises:
        zenoh.ZError: It cannot connect or listen, or a setting is wrong.
        BusError: It cannot start its threads.
    """
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    try:
        return zenoh.open(config)
    except BaseException as error:
        if type(error).__name__ == "PanicException":  # of the extension, which exports no name for it
            raise BusError("the bus", f"cannot start: {error}: is memory limited?") from error
        raise


def _tls_settings(credentials: Credentials | None, *, listens: bool) -> dict[str, object]:
    if credentials is None:
        return {}
    folder = credentials.folder
    pairs = ["connect", "listen"] if listens else ["connect"]
    files = {f"{side}_certificate": str(folder.certificate) for side in pairs}
    files |= {f"{side}_private_key": str(folder.key) for side in pairs}
    tls = files | {
        "root_ca_certificate": str(folder.authority),
        "enable_mtls": True,
        "verify_name_on_connect": True,
        "close_link_on_expiration": True,
    }
    return {f"transport/link/tls/{name}": value for name, value in tls.items()}
