"""Counts and times of the inputs received, as reported in the plant state."""

from passafe_protocol.messages import UNSEQUENCED, PlantInput, Received

from passafe_services.plant.transit_time import TransitTime


class InputAccount:
    """Counts and times of the inputs received.

    Attributes:
        transit: Transit time of inputs and the session of their filter.
        received_tick: Tick of the newest input received.
        lead_ns: Effective time of the newest input minus the plant time of its arrival, ns.
        late: Number of inputs that arrived after their effective time.
        refused: Number of inputs refused.
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

    def record_arrival(self, received: Received, plant_input: PlantInput, arrival_ns: int, made_ns: int) -> None:
        """Record the arrival of an input.

        Args:
            received: Its message.
            plant_input: The input.
            arrival_ns: Plant time of the arrival, ns.
            made_ns: Time at which the step of the oldest new input in the message was due, filter's clock, ns.
        """
        self.transit.record(received, arrival_ns, made_ns)
        if plant_input.tick >= self.received_tick:
            self.received_tick = plant_input.tick
            self.lead_ns = plant_input.effective_plant_ns - arrival_ns
