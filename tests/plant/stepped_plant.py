"""A plant node in steps, and inputs to it."""

from modelled_robot import modelled_robot
from passafe_protocol.messages import UNSEQUENCED, Header, PlantInput, PlantPhase, PlantState, Received
from passafe_services.plant.node import PlantNode
from passafe_services.plant_contract.fail_safe import FailSafe

from passafe import SampledPlant, damped_point
from passafe.limits import Limits

MS = 1_000_000
X0 = (2.0, 2.0, -1.0, -1.0)
U = (1.0, 0.0)
BOUND = 100.0
WAITING, RUNNING, HOLDING, FAIL_SAFE = PlantPhase


def make_node(*, playout_ns: int = 0, hold_ns: int = 3 * MS, norm: float | None = None) -> PlantNode:
    robot = damped_point(sigma=1.0, gamma_1=10.0)
    limits = Limits.of(2, BOUND, norm)
    plant = SampledPlant(robot.system, robot.system.x.T @ robot.system.x, 1e-3)
    rule = FailSafe(robot, limits, period_ns=MS, hold_ns=hold_ns)
    return PlantNode(modelled_robot(plant, rule, x0=X0, period_ns=MS, playout_ns=playout_ns), limits)


def head(epoch: int = 1, scheduled_ns: int = 0) -> Header:
    return Header("filter", epoch, 0, scheduled_ns, 0, 0, 0)


def loose(tick: int, due_ms: int, at_ms: int, u: tuple[float, ...] = U, hold_ns: int = 10 * MS) -> Received:
    """Return an unsequenced input."""
    return Received(head(), PlantInput(tick, u, due_ms * MS, hold_ns), at_ms * MS)


def sequenced(
    due_ms: int,
    at_ms: int,
    u: tuple[float, ...] = U,
    *,
    first: int = 0,
    basis: int | None = None,
    previous_u: tuple[float, ...] = (),
    epoch: int = 1,
    term: int = 0,
    made_ms: int = 0,
    hold_ns: int = 10 * MS,
) -> Received:
    """Return an input of the sequence that begins at ``first``, with the tick of its period."""
    known_break_ns = UNSEQUENCED if basis is None else basis * MS
    body = PlantInput(due_ms + 1, u, due_ms * MS, hold_ns, first * MS, known_break_ns, previous_u)
    return Received(head(epoch, made_ms * MS), body, at_ms * MS, term)


def states(node: PlantNode, at_ms: int, *inbox: Received) -> list[PlantState]:
    return [body for _, body in node.step(at_ms * MS, inbox) if isinstance(body, PlantState)]
