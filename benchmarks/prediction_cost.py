"""What predicting costs a tick, for a plant that is its model and for one that is not.

``python benchmarks/prediction_cost.py``. A tick takes in one state of the plant, predicts to the end of the horizon and
notes the input that was sent. The plant that is not its model is off by 1e-9 in every period: what it costs does not
depend on how wrong the model is.
"""

from collections.abc import Iterator
from statistics import median
from time import perf_counter_ns
from typing import Annotated

import typer
from passafe_protocol.messages import UNSEQUENCED, PlantPhase, PlantState
from passafe_services.filter.predictor import Predictor
from passafe_services.plant_contract.plant_model import period_ns
from passafe_services.scenarios.design import tank_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import CompiledScenario
from rich.console import Console
from rich.table import Table

ERROR = 1e-9


def main(
    scenario: Annotated[str, typer.Option(help="Scenario, by name or file.")] = "notomista-cai-2020",
    ticks: Annotated[int, typer.Option(min=10, help="Ticks of each measurement.")] = 300,
) -> None:
    """Time predictions over horizons of 50 to 400 periods."""
    table = Table(
        "horizon, periods", "µs a tick: exact model", "inexact model", "a period of the horizon", title=scenario
    )
    for horizon in (50, 100, 200, 400):
        exact, inexact = (median(tick_costs_us(scenario, horizon, ticks, error)) for error in (0.0, ERROR))
        table.add_row(str(horizon), f"{exact:.1f}", f"{inexact:.0f}", f"{inexact / horizon:.2f}")
    Console().print(table)


def tick_costs_us(name: str, horizon: int, ticks: int, error: float) -> Iterator[float]:
    """Yield what each tick takes, µs, with every state of the plant off by ``error`` from where the model goes."""
    scenario = load_scenario(name)
    compiled, dt_ns = CompiledScenario.of(scenario), period_ns(scenario)
    predictor = Predictor(compiled.model.dynamics, compiled.model.fail_safe, tank_of(scenario), dt_ns)
    sample, u = compiled.model.dynamics.at(scenario.plant.x0), (0.1,) * compiled.model.robot.system.m
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
            sequence_break_ns=UNSEQUENCED,
            input_since_ns=k * dt_ns,
        )
        begun_ns = perf_counter_ns()
        predictor.confirm(state)
        if k == 0:
            for ahead in range(horizon):
                predictor.at(ahead * dt_ns)
                predictor.sent(ahead * dt_ns, u)
        predictor.at((k + horizon) * dt_ns)
        predictor.sent((k + horizon) * dt_ns, u)
        if k > horizon:
            yield (perf_counter_ns() - begun_ns) / 1e3
        sample = compiled.model.dynamics.advance(state.x, u)


if __name__ == "__main__":
    typer.run(main)
