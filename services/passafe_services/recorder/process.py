"""Recorder process: opens the log and the bus, and records until it is stopped."""

from pathlib import Path
from secrets import token_hex
from typing import Final

from passafe_protocol.keys import DEFAULT_ROBOT
from passafe_protocol.messages import Message
from passafe_protocol.topics import Topic

from passafe_services.keys.signing import Signer
from passafe_services.log.chain import Chain
from passafe_services.log.log_writer import RunMetadata, run_metadata
from passafe_services.log.segmented_log import Rotation, SegmentedLog
from passafe_services.loop.bus import open_bus
from passafe_services.loop.health_report import HealthReporter
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.process_options import ProcessOptions
from passafe_services.loop.readiness import announce_ready
from passafe_services.loop.realtime import RECORDER_PRIORITY, request_realtime
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.stop import stop_requests
from passafe_services.recorder.background_log import BackgroundLog
from passafe_services.recorder.message_recorder import MessageRecorder
from passafe_services.recorder.record_loop import record
from passafe_services.scenarios.info import versions

NAME: Final = "recorder"
_IDENTITY_BYTES: Final = 16


def run_recorder(
    endpoint: RouterEndpoint,
    path: Path,
    metadata: RunMetadata,
    *,
    epoch: int,
    rotation: Rotation | None = None,
    robot: str = DEFAULT_ROBOT,
    lifeline: bool = False,
    health: HealthReporter | None = None,
) -> MessageRecorder:
    """Record all messages of a robot on the bus until stopped; main thread only.

    The log is opened first, so that a folder that cannot be written is reported before anything else starts. It is
    signed with the keys of the process, if it has any. The process reports that it is ready once no message published
    from then on can be missed.

    Args:
        endpoint: Address of the router.
        path: The log to write.
        metadata: Metadata records of the log, see ``run_metadata``.
        epoch: Session number of the published messages.
        rotation: When the next file begins.
        robot: Robot whose messages are recorded.
        lifeline: Whether standard input is a lifeline (see ``passafe_services.loop.stop``).
        health: Reports the health of its loop to what supervises the process.

    Returns:
        The recorder with its counts.

    Raises:
        LogWriteError: The log cannot be created, or not written in the end.
        KeysError: The keys cannot be read.
        BusError: There is no router.
    """
    request_realtime(RECORDER_PRIORITY)  # a refusal is reported by the loops, which need it more
    signer = None if endpoint.credentials is None else Signer.of(endpoint.credentials)
    chain = Chain(token_hex(_IDENTITY_BYTES), signer)
    with (
        stop_requests(lifeline=lifeline) as stop,
        BackgroundLog(SegmentedLog(path, metadata, chain, rotation=rotation)) as log,
        open_bus(endpoint, robot=robot) as bus,
    ):
        reader = bus.recording_reader()
        outlet = Outlet(bus, NAME, epoch, health)

        def publish(topic: Topic, body: Message, now_ns: int) -> None:
            outlet.publish(topic, body, scheduled_ns=now_ns, started_ns=now_ns)

        announce_ready(NAME)
        return record(reader, log, publish=publish, stop=stop)


def start(options: ProcessOptions) -> None:
    """Record until stopped."""
    metadata = run_metadata(
        scenario_json=options.scenario.model_dump_json(),
        versions=versions(),
        driver="live",
        planned_s=options.duration_s,
    )
    run_recorder(
        options.endpoint,
        options.out,
        metadata,
        epoch=options.epoch,
        rotation=Rotation(
            size_bytes=None if options.rotate_mb is None else round(options.rotate_mb * 1e6),
            after_ns=None if options.rotate_s is None else round(options.rotate_s * 1e9),
        ),
        robot=options.robot,
        lifeline=options.lifeline,
        health=options.health,
    )
