"""Run the dashboard as a process of the system: read the bus, serve the page, end on request."""

import asyncio
import gc
import socket
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Final

from fastapi import FastAPI
from passafe_protocol.keys import DEFAULT_ROBOT
from passafe_protocol.messages import EmergencyStop, LinkConfig, Steer, StopClear
from passafe_protocol.topics import LINK_CONFIG, TOPIC_OF_BODY
from passafe_services.loop.bus import Bus, open_bus
from passafe_services.loop.health_report import HealthReporter
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.process_options import ProcessOptions
from passafe_services.loop.readiness import announce_ready
from passafe_services.loop.receipts import Receipts
from passafe_services.loop.router_endpoint import LOOPBACK, RouterEndpoint
from passafe_services.loop.stop import Stop, StopReason, stop_requests
from passafe_services.scenarios.schema import Scenario

from passafe_dashboard.address import listening_socket
from passafe_dashboard.archive.archive import Archive
from passafe_dashboard.live.broadcast import FRAME_HZ, Broadcast
from passafe_dashboard.live.bus_reader import BusReader
from passafe_dashboard.live.command_echo import CommandEcho
from passafe_dashboard.live.drive_requests import DriveRequests
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.link_requests import LinkRequests
from passafe_dashboard.live.session_requests import SessionRequests
from passafe_dashboard.live.stop_requests import StopRequests
from passafe_dashboard.page_access import PageAccess, ShownCertificate, shown_certificate
from passafe_dashboard.priority import serve_before_others
from passafe_dashboard.routes.application import create_app
from passafe_dashboard.routes.own_hosts import OwnHosts
from passafe_dashboard.server import PageServer, page_server

NAME: Final = "dashboard"
CHECK_PERIOD_S: Final = 0.05
LAST_FRAME_TIMEOUT_S: Final = 0.5
"""Time for pages to receive their last frame."""


def serve(
    endpoint: RouterEndpoint,
    port: int,
    *,
    host: str = LOOPBACK,
    names: Sequence[str] = (),
    access: PageAccess | None = None,
    robot: str = DEFAULT_ROBOT,
    scenario: Scenario | None = None,
    epoch: int | None = None,
    lifeline: bool = False,
    frame_hz: float = FRAME_HZ,
    health: HealthReporter | None = None,
    control_channel: int | None = None,
    runs: Path | None = None,
) -> StopReason | None:
    """Serve the live page of the system behind a router until asked to stop; main thread only.

    Args:
        endpoint: Where the router listens.
        port: TCP port of the page; 0 takes a free one, which is printed.
        host: Address of the page; other than loopback, other hosts reach it too.
        names: Further names by which the page is reached; a browser that asks by any other is refused.
        access: Token and certificate of the page; if not given, those that the address asks for are made.
        robot: Robot whose topics the page shows.
        scenario: Configuration until a ScenarioInfo arrives.
        epoch: Session number of the published messages; the wall clock in ns if not given.
        lifeline: Whether standard input is a lifeline (see ``passafe_services.loop.stop``).
        frame_hz: Frames a second for each page, at most.
        health: Reports the health of the loop that reads the bus, to what supervises the process.
        control_channel: Descriptor of the channel to the supervisor of a demo; ``None``: no demo.
        runs: Folder of the logs and experiments to show besides; ``None``: none.

    Returns:
        The reason why it ended.

    Raises:
        PagePortInUseError: Another program listens on the port.
        PageAddressError: The address cannot be listened on for another reason.
        PageAccessError: The page's certificate cannot be used.
        BusError: There is no router.
    """
    access = access or PageAccess.of(host)
    serve_before_others()
    with stop_requests(lifeline=lifeline) as stop, listening_socket(host, port) as listener:
        feed = Feed(scenario)
        with open_bus(endpoint, robot=robot) as bus:
            outlet = Outlet(bus, NAME, time.time_ns() if epoch is None else epoch, health)
            receipts = Receipts(bus)
            reader = BusReader(bus, feed, outlet)
            broadcast = Broadcast(feed, read=reader.read, clock=time.monotonic_ns, frame_hz=frame_hz)
            links = LinkRequests(broadcast, partial(_request_settings, outlet))
            stops = StopRequests(broadcast, partial(_publish, outlet), epoch=outlet.epoch)
            drives = DriveRequests(broadcast, partial(_publish, outlet), CommandEcho(bus).newest)
            hosts, trouble = OwnHosts.of(host, names), partial(_bus_trouble, bus)
            session = SessionRequests(feed, control_channel)
            archive = None if runs is None else Archive(runs, beside_robot=True)
            app = create_app(
                broadcast,
                links,
                stops,
                drives,
                session=session,
                hosts=hosts,
                access=access,
                bus_trouble=trouble,
                archive=archive,
            )
            with shown_certificate(access, [host, *names]) as shown:
                server = page_server(app, shown)
            asyncio.run(_run(app, server, broadcast, listener, stop, partial(_print_address, listener, access, shown)))
            receipts.wait_for(outlet)
    return stop.reason


def _bus_trouble(bus: Bus) -> str:
    """Return why nothing can be read from the bus; empty if that is not so."""
    return bus.refusal or ("" if bus.router else "no router is connected")


def _request_settings(outlet: Outlet, config: LinkConfig, now_ns: int) -> tuple[str, int, int]:
    """Publish a request for other settings of a link; return source, epoch and number, which its answer will name."""
    number = outlet.sent(LINK_CONFIG)
    outlet.publish(LINK_CONFIG, config, scheduled_ns=now_ns, started_ns=now_ns)
    return outlet.source, outlet.epoch, number


def _publish(outlet: Outlet, body: EmergencyStop | StopClear | Steer, now_ns: int) -> None:
    """Publish a press of the emergency stop, its clear, or who drives."""
    outlet.publish(TOPIC_OF_BODY[type(body)], body, scheduled_ns=now_ns, started_ns=now_ns)


async def _run(
    app: FastAPI,
    server: PageServer,
    broadcast: Broadcast,
    listener: socket.socket,
    stop: Stop,
    print_address: Callable[[], None],
) -> None:
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    await _until(lambda: server.started or serving.done())
    if server.started:
        gc.collect()
        gc.freeze()  # the collector need not visit the objects that the charts were made from
        print_address()
        announce_ready(NAME)
        broadcasting: asyncio.Task[None] = app.state.broadcasting
        await _until(lambda: stop.reason is not None or broadcasting.done() or serving.done())
        if not broadcasting.done():
            broadcast.finish("The run has ended. The page shows its last state.")
            await _until(lambda: not broadcast.clients, timeout_s=LAST_FRAME_TIMEOUT_S)
    archive: Archive | None = app.state.archive
    if archive is not None:
        await archive.close()  # answers requests that wait for a job
    server.should_exit = True
    await serving
    if server.started and broadcasting.done() and not broadcasting.cancelled():
        broadcasting.result()


async def _until(condition: Callable[[], bool], timeout_s: float | None = None) -> None:
    end_s = None if timeout_s is None else time.monotonic() + timeout_s
    # Nothing sets an asyncio.Event here: a request to stop comes from a signal handler, the rest from uvicorn
    while not condition() and (end_s is None or time.monotonic() < end_s):  # noqa: ASYNC110 - see above
        await asyncio.sleep(CHECK_PERIOD_S)


def _print_address(listener: socket.socket, access: PageAccess, shown: ShownCertificate | None) -> None:
    host, port = listener.getsockname()[:2]
    sys.stdout.write(f"page at {access.address(host, port)}\n")
    if shown is not None and shown.fingerprint:
        sys.stdout.write(f"its certificate was made now; compare what the browser shows: SHA-256 {shown.fingerprint}\n")
    sys.stdout.flush()


def start(options: ProcessOptions) -> None:
    """Serve the live page until asked to stop."""
    serve(
        options.endpoint,
        options.port,
        host=options.host,
        names=options.page_names,
        access=PageAccess.of(
            options.host,
            token=options.page_token,
            certificate=options.page_certificate,
            key=options.page_key,
            is_open=options.open_page,
        ),
        robot=options.robot,
        scenario=options.scenario,
        epoch=options.epoch,
        lifeline=options.lifeline,
        health=options.health,
        control_channel=options.control_channel,
        runs=options.runs,
    )
