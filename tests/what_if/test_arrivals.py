from pathlib import Path

from passafe_protocol.messages import PlantInput, PlantState
from passafe_services.plant_contract.plant_model import period_ns
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.arrivals import at_the_plant, places
from passafe_services.tools.what_if.recorded_steps import PLANT, sessions_of
from passafe_services.tools.what_if.route import LOST_NS

LIVE = Path(__file__).parents[1] / "golden" / "live.mcap"


def test_inputs_after_the_last_state_never_came() -> None:
    log = RunLog.read(LIVE)
    inputs, states = log.of(PlantInput), log.of(PlantState)
    newest = states[-1].body.received_tick

    found = at_the_plant(log, sessions_of(log, PLANT, period_ns(log.identity.scenario)))

    at_ns = {
        message.body.tick: found.at[place].at_ns
        for place, message in zip(places(message.header for message in inputs), inputs, strict=True)
    }
    never_came = {tick for tick, arrival_ns in at_ns.items() if arrival_ns == LOST_NS}
    assert never_came == {*range(newest + 1, len(inputs) + 1)}
    assert at_ns[newest] <= states[-1].header.started_ns
    assert len(inputs) > newest
