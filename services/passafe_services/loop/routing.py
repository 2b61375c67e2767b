"""Router: forwards messages between sessions as access control permits, and tells each whom it admits."""

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager

import zenoh

from passafe_services.loop.access import ADMISSION, access_control, published_topics
from passafe_services.loop.admission import SEPARATOR
from passafe_services.loop.errors import BusError
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.session import open_session, router_settings


@contextmanager
def listening_router(endpoint: RouterEndpoint, linked: Sequence[RouterEndpoint] = ()) -> Iterator[None]:
    """Run a router that listens at ``endpoint`` until the block ends.

    With credentials it speaks TLS only, asks each session for a certificate of its authority, and lets it do what the
    topic table says of its role. Without, everybody who reaches it may do everything.

    Args:
        endpoint: Where it listens, with its credentials.
        linked: Routers that it connects to, such as that of another site; they must not link back.

    Raises:
        BusError: It cannot listen there.
        KeysError: The list of those whom it admits cannot be read.
        IdentityError: The list has a line that is no common name of ours.
    """
    credentials = endpoint.credentials
    settings = router_settings(endpoint.locator, credentials, [router.locator for router in linked])
    if credentials is not None:
        settings["access_control"] = access_control(credentials.folder.read_admitted())
    try:
        session = open_session(settings)
    except zenoh.ZError as error:
        reason, _, _ = str(error).partition(" at /")  # the rest are locations in Zenoh's source
        raise BusError(endpoint.locator, reason) from error
    with closing(session):
        if credentials is not None:
            session.declare_queryable(f"{ADMISSION}/*", _answer, complete=True)
        yield


def _answer(query: zenoh.Query) -> None:
    """Answer a holder; access control has let the query in, so that this router admits it."""
    key = str(query.key_expr)
    with query:
        role, *_ = key.removeprefix(f"{ADMISSION}/").split(".")
        query.reply(key, SEPARATOR.join(topic.name for topic in published_topics(role)))
