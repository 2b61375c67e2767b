"""Runs a session under a supervisor, which takes the requests of its page."""

from passafe_services.loop.process_exit import RunOutcome
from passafe_services.loop.supervision import PrintLine, Supervision
from passafe_services.loop.supervisor import supervised
from passafe_services.session.control_server import ControlServer
from passafe_services.session.run_requests import Prepare, RunRequests
from passafe_services.session.run_session import RunSession


def run_session(session: RunSession, prepare: Prepare, *, emit: PrintLine | None = None) -> RunOutcome:
    """Run a session until a signal or a process ends it; main thread only; see ``supervise``.

    Args:
        session: The session.
        prepare: Prepares the runs that the page requests, see ``RunRequests``.
        emit: Called with each line to print; standard output if not given.

    Returns:
        How it ended, with the exits of the processes that all runs shared.
    """
    server = ControlServer(session, RunRequests(session, prepare))

    async def run(supervision: Supervision) -> RunOutcome:
        end = await session.run(supervision)
        await supervision.stop()
        return RunOutcome.of(end, supervision.take_exits())

    return supervised(run, emit=emit, on_change=server.publish, on_control=server.connect)
