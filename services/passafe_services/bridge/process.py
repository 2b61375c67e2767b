"""Bridge process: reads the bus and serves it to viewers until it is stopped."""

import sys
from time import monotonic_ns
from typing import Final

from passafe.errors import MissingPackageError
from passafe_services.bridge.bus_view import POLL_HZ, BusView
from passafe_services.loop.bus import open_bus
from passafe_services.loop.pace import Pace
from passafe_services.loop.process_options import ProcessOptions
from passafe_services.loop.readiness import announce_ready
from passafe_services.loop.stop import stop_requests

NAME: Final = "bridge"
HEALTH_STEPS: Final = round(POLL_HZ)
"""Steps between two reports of health to what supervises the process."""


def start(options: ProcessOptions) -> None:
    """Serve viewers until asked to stop; main thread only.

    Raises:
        MissingPackageError: The package of the server is not installed.
        BridgePortError: The address cannot be listened on.
        BusError: There is no router.
    """
    try:
        from passafe_services.bridge.viewer_server import open_viewer_server  # noqa: PLC0415 - an extra
    except ModuleNotFoundError as error:
        raise MissingPackageError.of(error, "foxglove") from error
    with (
        stop_requests(lifeline=options.lifeline) as stop,
        open_viewer_server(options.host, options.port) as server,
        open_bus(options.endpoint, robot=options.robot) as bus,
    ):
        view = BusView(bus, options.scenario)
        sys.stdout.write(f"bridge at ws://{options.host}:{server.port}, for Foxglove or Lichtblick\n")
        sys.stdout.flush()
        announce_ready(NAME)
        pace = Pace(monotonic_ns(), POLL_HZ)
        while not stop.wait(max(pace.due_ns - monotonic_ns(), 0) * 1e-9):
            pace.begin(monotonic_ns())
            for message in view.poll():
                server.show(message)
            pace.end(monotonic_ns())
            if pace.steps % HEALTH_STEPS == 0:
                options.health.report(connected=bus.connected, steps=pace.steps, skipped=pace.skipped)
