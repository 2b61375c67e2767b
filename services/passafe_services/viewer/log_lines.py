"""Events as log lines of Foxglove's schema."""

from typing import Final

from foxglove_schemas_protobuf.Log_pb2 import Log
from passafe_protocol.messages import EmergencyStop, Event, Header, Message, StopClear

from passafe_services.viewer.view_message import ViewMessage, ViewTopic, timestamp

LINES: Final = ViewTopic(name="/passafe/log", message_type=Log)
_LEVELS: Final = {"info": Log.INFO, "warning": Log.WARNING, "error": Log.ERROR}


def log_line(header: Header, body: Message, time_ns: int) -> ViewMessage | None:
    """Return the log line for a message: an event, an emergency stop or its clearing; ``None`` for others."""
    match body:
        case Event():
            level, text = _LEVELS.get(body.severity, Log.UNKNOWN), body.text
        case EmergencyStop():
            level, text = Log.ERROR, f"emergency stop: {body.reason}"
        case StopClear():
            level, text = Log.WARNING, f"emergency stop cleared: {body.reason}"
        case _:
            return None
    line = Log(timestamp=timestamp(time_ns), level=level, message=text, name=header.source)
    return ViewMessage(LINES, line, time_ns)
