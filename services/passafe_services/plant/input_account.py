"""The plant's account of the inputs that arrived, as its state reports it."""

from passafe_protocol.messages import UNSEQUENCED, Header, PlantInput

from passafe_services.plant.transit_time import TransitTime


class InputAccount:
    """Counts and times of the inputs that arrived.

    Attributes:
        transit: How long inputs took to come, and of which filter's session they were.
        received_tick: Tick of the newest input received.
        lead_ns: How long before its effect the newest input arrived, ns.
        late: Inputs that arrived after their effective time.
        refused: Inputs that were refused.
        sequence_break_ns: Plant time of the last sequence break; −1 before the first.
    """

    def __init__(self) -> None:
        """Start before the first input."""
        self.transit = TransitTime()
        self.received_tick = 0
        self.lead_ns = 0
        self.late = 0
        self.refused = 0
        self.sequence_break_ns = UNSEQUENCED

    def note_arrival(self, header: Header, plant_input: PlantInput, arrival_ns: int, made_ns: int) -> None:
        """Note the arrival of an input.

        Args:
            header: Its header.
            plant_input: The input.
            arrival_ns: Plant time of the arrival, ns.
            made_ns: When the oldest input that it brought was due to be made, by the filter's clock, ns.
        """
        self.transit.note(header.epoch, arrival_ns, made_ns)
        if plant_input.tick >= self.received_tick:
            self.received_tick = plant_input.tick
            self.lead_ns = plant_input.effective_plant_ns - arrival_ns
