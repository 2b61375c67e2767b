"""Reports of a tick on its rows: they follow from its own answer, though another one may be accepted as well."""

import numpy as np
import pytest
from msgspec.structs import replace
from passafe_protocol.messages import CommandState, FilterStatus, FilterTick, Header
from passafe_protocol.topics import TICK
from passafe_services.filter.operator_request import OperatorRequest
from passafe_services.filter.telemetry import Telemetry, TickRecord
from passafe_services.log.continuity import LoggedMessage
from passafe_services.log.message_block import MessageBlock
from passafe_services.log.message_columns import columns_of
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.review.explanation_check import ExplanationCheck

from passafe.filter import SafetyPassivityFilter
from passafe.override import Explainer

SCENARIO = load_scenario("walls-and-disks")
CORE = SafetyPassivityFilter(design_of(SCENARIO, robot_of(SCENARIO)))
AT_REST = CORE.decide((0.0, 1.0, 0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), 1.0)
GRADIENTS = AT_REST.part("G").reshape(CORE.layout.shapes["G"], order="F")[: CORE.constraints, :2]
GAIN = SCENARIO.dt_s * SCENARIO.filter.k_i
ROW = 0
PUSH = 5e-5
"""Less than two accepted answers may differ by, and more than a row has to push to be active."""


def tick_of_another_answer() -> FilterTick:
    """Return the tick of an answer that a row has pushed, where none has to."""
    request = OperatorRequest((0.0, 0.0), (0.0, 0.0), 0, CommandState.COUNTS, 1.0)
    telemetry = Telemetry(CORE, Explainer(CORE))
    tick = TickRecord(telemetry, 1, FilterStatus.PASSED, AT_REST, AT_REST, 0, 1.0, (), 0, request, 0)()
    held_back = tuple((PUSH / GAIN * GRADIENTS[ROW]).tolist())
    v = tuple((PUSH / SCENARIO.dt_s * GRADIENTS[ROW]).tolist())
    pushed = replace(tick, v=v, override=replace(tick.override, held_back=held_back))
    return with_row(pushed, dual=PUSH, active=True, share=1.0)


def with_row(tick: FilterTick, **fields: float) -> FilterTick:
    rows = [*tick.rows]
    rows[ROW] = replace(rows[ROW], **fields)
    return replace(tick, rows=tuple(rows))


def differences(tick: FilterTick) -> dict[str, float]:
    message = LoggedMessage(Header("filter", 1, 1, 0, 0, 0, 0), tick)
    columns = columns_of(TICK, [message], {"header.sequence", *ExplanationCheck.wants})
    found = ExplanationCheck(CORE).differences(
        MessageBlock(TICK, "filter", 1, 0, columns),
        np.array([0]),
        AT_REST.block[None],
        np.array([True]),
        GRADIENTS.T[:, :, None],
    )
    return {what: float(difference[0]) for what, difference in found.items()}


def test_push_of_another_accepted_answer_is_no_difference() -> None:
    found = differences(tick_of_another_answer())

    assert found["active row"] == 0.0
    assert found["share of a row"] < 1e-9
    assert found["held back"] < 1e-9


def test_held_back_is_what_the_change_of_the_input_says() -> None:
    tick = tick_of_another_answer()

    assert differences(replace(tick, v=(0.0, 0.0)))["held back"] > 1e-5


@pytest.mark.parametrize(
    ("fields", "what"),
    [
        ({"active": False, "share": 0.0}, "active row"),
        ({"dual": 0.0, "share": 0.0}, "active row"),
        ({"share": 0.9}, "share of a row"),
        ({"dual": 2 * PUSH}, "share of a row"),
    ],
)
def test_row_that_contradicts_its_own_dual_differs(fields: dict[str, float], what: str) -> None:
    assert differences(with_row(tick_of_another_answer(), **fields))[what] > 0.03
