"""Logs a lockstep loop: an observer that does the work of the recorder process."""

from passafe_protocol.codec import encode
from passafe_protocol.messages import Header, Message
from passafe_protocol.topics import Topic

from passafe_services.log.log_writer import LogWriter


class LockstepLog:
    """Observer that writes every recorded message of a lockstep loop, encoded as by a live publisher."""

    def __init__(self, log: LogWriter) -> None:
        self._log = log

    def __call__(self, topic: Topic, header: Header, body: Message) -> None:
        """Log one message."""
        if topic.recorded:
            self._log.write(
                topic.key(header.source),
                encode(header, body),
                sequence=header.sequence,
                wall_ns=header.wall_ns,
            )
