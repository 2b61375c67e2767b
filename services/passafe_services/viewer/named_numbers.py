"""Rows of tables as messages: every number has a name of its own, so that any viewer plots it by name."""

from passafe_services.tables.columns import Column
from passafe_services.tables.layout import TableLayout
from passafe_services.tables.log_messages import LoggedRow
from passafe_services.viewer.schemas import message_type_of
from passafe_services.viewer.view_message import ViewMessage, ViewTopic


class NamedNumbers:
    """Messages of one topic as messages with a field for each column of its table.

    The message type is made anew when the layout has grown.

    Args:
        layout: Layout of the table.
    """

    def __init__(self, layout: TableLayout) -> None:
        self._layout = layout
        self._columns: tuple[Column, ...] = ()
        self._names: tuple[str, ...] = ()
        self._topic: ViewTopic | None = None

    def view(self, row: LoggedRow, start_ns: int) -> ViewMessage:
        """Return a message, which the layout has noted, as a viewer takes it."""
        topic = self._topic
        if topic is None or self._columns is not self._layout.columns:
            self._columns = self._layout.columns
            self._names = tuple(column.name for column in self._columns)
            name = "".join(part.capitalize() for part in row.topic.name.split("_"))
            topic = ViewTopic(name=f"/passafe/{row.topic.name}", message_type=message_type_of(name, self._columns))
            self._topic = topic
        values = self._layout.row(row.log_ns, start_ns, row.header, row.body)
        return ViewMessage(topic, topic.message_type(**dict(zip(self._names, values, strict=True))), row.log_ns)
