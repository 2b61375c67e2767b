"""Times prediction in a filter step, for a plant that is its model and for one that is not.

``python benchmarks/prediction_cost.py``. A tick reads one state of the plant, predicts to the end of the horizon and
notes the input that was sent. The plant that is not its model is off by 1e-9 in every period: the cost does not
depend on how wrong the model is.
"""

from functools import partial
from statistics import median
from time import perf_counter_ns
from typing import Annotated

import typer
from passafe_protocol.messages import PlantPhase, PlantState
from passafe_services.filter.predictor import Predictor
from passafe_services.plant_contract.plant_model import period_ns
from passafe_services.scenarios.design import tank_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import CompiledScenario
from report import AsJson, Ratio, Report, Smallest, spread
from timing import in_turn

ERROR = 1e-9


def main(
    scenario: Annotated[str, typer.Option(help="Scenario, by name or file.")] = "notomista-cai-2020",
    ticks: Annotated[int, typer.Option(min=10, help="Ticks of each measurement.")] = 300,
    rounds: Annotated[int, typer.Option(min=1, help="Rounds.")] = 3,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Time predictions over horizons of 50 to 400 periods."""
    horizons: tuple[int, ...] = (50, 100, 200, 400)
    if smallest:
        ticks, rounds, horizons = 10, 1, (50,)
    report = Report(
        title=f"Prediction, {scenario}, {ticks} ticks, {rounds} rounds",
        columns=(
            "horizon, periods",
            "exact model, µs a tick",
            "inexact model, µs a tick",
            "µs a period of the horizon",
        ),
    )
    for horizon in horizons:
        measures = [partial(tick_us, scenario, horizon, ticks, error) for error in (0.0, ERROR)]
        exact, inexact = in_turn(measures, rounds)
        each = f"{median(inexact) / horizon:.2f}"
        report.rows.append((str(horizon), spread(exact), spread(inexact, 0), each))
        report.ratios.append(Ratio.of_rounds(f"inexact model, {horizon} periods", inexact, "exact model", exact))
    report.finish(as_json=as_json)


def tick_us(name: str, horizon: int, ticks: int, error: float) -> float:
    """Return the median time of a tick, µs, with every state off by ``error`` from where the model goes."""
    scenario = load_scenario(name)
    compiled, dt_ns = CompiledScenario.of(scenario), period_ns(scenario)
    predictor = Predictor(compiled.model.dynamics, compiled.model.fail_safe, tank_of(scenario), dt_ns)
    sample, u = compiled.model.dynamics.at(scenario.plant.x0), (0.1,) * compiled.model.robot.system.m
    times = []
    for k in range(ticks + horizon):
        state = PlantState(
            plant_ns=k * dt_ns,
            x=(sample.x[0] + error, *sample.x[1:]),
            y=sample.y,
            u=u,
            applied_tick=k,
            phase=PlantPhase.RUNNING,
            energy_in_j=0.0,
            energy_stored_j=sample.stored_j,
            input_lead_ns=0,
            inputs_late=0,
            inputs_refused=0,
            integration_error=0.0,
            received_tick=k,
            input_since_ns=k * dt_ns,
        )
        begin_ns = perf_counter_ns()
        predictor.confirm(state)
        if k == 0:
            for ahead in range(horizon):
                predictor.predict(ahead * dt_ns)
                predictor.record_sent(ahead * dt_ns, u)
        predictor.predict((k + horizon) * dt_ns)
        predictor.record_sent((k + horizon) * dt_ns, u)
        if k > horizon:
            times.append((perf_counter_ns() - begin_ns) / 1e3)
        sample = compiled.model.dynamics.advance(state.x, u)
    return median(times)


if __name__ == "__main__":
    typer.run(main)
