from math import pi, sqrt

import casadi as ca
import numpy as np
import pytest
from msgspec import structs
from passafe_services.filter.barrier_distance import BarrierDistance, DistanceReading
from passafe_services.filter.event_emitter import (
    CHECK_PERIOD_NS,
    EVENT_PERIOD_NS,
    REPEAT_AFTER_NS,
    OverrideEventEmitter,
)
from passafe_services.filter.override_text import OverrideText

from passafe.answers.replaced_answer import BACKUP, BETWEEN
from passafe.barrier_chain import Barrier, derive_chain
from passafe.barriers import disk_keep_out, half_plane, speed_limit
from passafe.class_k import Linear
from passafe.decision import Decision, Status
from passafe.design import FilterDesign, Law, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.models.damped_point import damped_point
from passafe.models.robot import Robot
from passafe.override import Explainer
from passafe.passivity import Passivity

MS = 1_000_000
ROBOT = damped_point(sigma=1.0)
REST = (0.0, 0.0)


def barrier(name: str, h: ca.SX, levels: int = 3, gain: float = 10.0) -> Barrier:
    return Barrier(name=name, h=h, class_k=(Linear(gain=gain),) * levels)


def wall(name: str, sign: float, at: float) -> Barrier:
    """Return the wall sign·p₁ ≥ at."""
    return barrier(name, half_plane(ROBOT.position, normal=(sign, 0.0), offset=at))


def core_of(
    *barriers: Barrier, mode: Mode = Mode.SAFE, law: Law = Law.SAMPLED, bound: float = 100.0
) -> SafetyPassivityFilter:
    return SafetyPassivityFilter(
        FilterDesign(
            system=ROBOT.system,
            u_fb=ca.SX.zeros(2),
            fail_safe=ca.SX.zeros(2),
            barriers=barriers,
            passivity=Passivity(V=ca.sumsqr(ROBOT.system.x)),
            k_i=100.0,
            dt_s=1e-3,
            input_bound=bound,
            law=law,
            mode=mode,
            between_samples=False,
        )
    )


def sentence(core: SafetyPassivityFilter, x: tuple[float, ...], u_h: tuple[float, float], robot: Robot = ROBOT) -> str:
    decision = core.decide(x, REST, u_h, REST, start=True)
    return OverrideText(core, robot, "m/s²").sentence(decision, Explainer(core).override(decision))


def test_sentence_has_obstacle_distance_and_passing_fraction() -> None:
    # ψ₂ = u₁ + (20 − 1)·0 + 100·0.04 ≥ 0: of u₁ = −7.1, −4 passes, which is 56.3 %.
    assert sentence(core_of(wall("west", 1.0, -1.0)), (-0.96, 0.0, 0.0, 0.0), (-7.1, 0.0)) == (
        "held back 3.1 m/s²: obstacle `west`, 0.04 m from its limit; 56 % of the command would have passed unchanged"
    )


def test_beyond_the_limit_no_part_passes() -> None:
    assert sentence(core_of(wall("west", 1.0, -1.0)), (-1.02, 0.0, 0.0, 0.0), (-1.0, 0.0)) == (
        "held back 3 m/s²: obstacle `west`, 0.02 m beyond its limit; no part of the command would have passed unchanged"
    )


def test_a_speed_limit_is_no_obstacle() -> None:
    # h = 4 − v², ψ₁ = 2v² − 2v·u + 10h at v = (1.9, 0): u₁ ≤ 1.9 + 10·0.39/3.8 = 2.926; h/|∂h/∂v| = 0.39/3.8.
    slow = barrier("slow", speed_limit(ROBOT.velocity, limit=2.0), levels=2)

    assert sentence(core_of(slow), (0.0, 0.0, 1.9, 0.0), (10.0, 0.0)) == (
        "held back 7.1 m/s²: barrier `slow`, 0.1 m/s from its limit; 29 % of the command would have passed unchanged"
    )


def test_a_barrier_of_places_and_velocities_shows_its_h() -> None:
    # h = 1 + p₁ + v₁ has relative degree 1: ψ₁ = v₁ − v₁ + u₁ + 10h.
    mixed = barrier("mixed", 1 + ROBOT.position[0] + ROBOT.velocity[0], levels=2)

    assert sentence(core_of(mixed), (-0.5, 0.0, 0.0, 0.0), (-10.0, 0.0)).startswith(
        "held back 5 m/s²: barrier `mixed`, h = 0.5;"
    )


def test_limits_of_the_input_have_one_name() -> None:
    assert sentence(core_of(bound=2.0), (0.0,) * 4, (-5.0, 6.0)) == (
        "held back 5 m/s²: input limit; 33 % of the command would have passed unchanged"
    )


@pytest.mark.parametrize("law", Law)
def test_passivity_is_energy(law: Law) -> None:
    # Sampled: h_u = vᵀu − 2pᵀv + 2‖v‖² − 2vᵀu with v = (1, 0), p = 0 asks for u₁ ≤ 2.
    words = sentence(core_of(mode=Mode.PASSIVE, law=law), (0.0, 0.0, 1.0, 0.0), (8.0, 0.0))

    assert ": energy;" in words


def test_two_obstacles_are_named_in_the_order_of_their_shares() -> None:
    south = barrier("south", half_plane(ROBOT.position, normal=(0.0, 1.0), offset=-1.0))
    words = sentence(core_of(wall("west", 1.0, -1.0), south), (-1.0, -1.0, 0.0, 0.0), (-2.0, -3.0))

    assert words.startswith(
        "held back 3.6 m/s²: obstacle `south`, 0 m from its limit and obstacle `west`, 0 m from its limit;"
    )


def test_conflicting_rows_are_described() -> None:
    # p₁ ≥ 0.01 and −p₁ ≥ 0.01: at rest in the middle, u₁ ≥ 1 and u₁ ≤ −1.
    core = core_of(wall("a", 1.0, 0.01), wall("b", -1.0, 0.01))
    words = sentence(core, (0.0,) * 4, (0.0, 0.0))

    assert words == "relaxed 1 m/s² of obstacle `a` and 1 m/s² of obstacle `b`: they conflict"


def test_rows_in_conflict_with_the_limits_are_described() -> None:
    root = 1 / sqrt(2)
    one = core_of(wall("a", 1.0, 0.05), bound=2.0)
    sides = (
        barrier(name, half_plane(ROBOT.position, normal=(root, y), offset=0.05))
        for name, y in (("a", root), ("b", -root))
    )

    assert sentence(one, (0.0,) * 4, (0.0, 0.0)).endswith(
        "relaxed 3 m/s² of obstacle `a`: it requires more than the input limits allow"
    )
    assert sentence(core_of(*sides, bound=2.0), (0.0,) * 4, (0.0, 0.0)).endswith(
        "they conflict within the input limits"
    )


@pytest.mark.parametrize(
    ("solver", "sent"), [(BACKUP, "the fail-safe law acts"), (BETWEEN, "what keeps the barriers longest is sent")]
)
def test_what_is_sent_in_the_place_of_an_answer_is_named(solver: str, sent: str) -> None:
    core = core_of(wall("a", 1.0, 0.0), bound=2.0)
    decision = structs.replace(core.decide((0.01, 0.0, -5.0, 0.0), REST, REST, REST), solver=solver)
    decision.answer.relax[:] = 0.0  # it belongs to the program's answer alone
    words = OverrideText(core, ROBOT, "m/s²").sentence(decision, Explainer(core).override(decision))

    assert words.endswith(f"no input within the limits keeps every row: {sent}")


def test_relaxed_hard_passivity_is_called_energy() -> None:
    core = core_of(mode=Mode.PASSIVE, law=Law.CONTINUOUS)
    # ∂h_u/∂u = −x₂ all but vanishes, and −(2x₁ + u)ᵀu is far below zero (theory, section 5).
    given_up = core.decide((9.0, 0.0, 1e-3, 0.0), (50.0, 0.0), REST, REST)

    assert given_up.status is Status.INFEASIBLE
    assert "m/s² of energy: it requires" in OverrideText(core, ROBOT, "m/s²").sentence(
        given_up, Explainer(core).override(given_up)
    )


def test_relaxed_passivity_is_reported_with_its_amount() -> None:
    # At (−1.05, 0) inside a wall the safe input points outward and passivity asks for the opposite.
    core = core_of(wall("west", 1.0, -1.0), mode=Mode.BOTH)
    decision = core.decide((-1.2, 0.0, 0.5, 0.0), REST, REST, REST, start=True)
    words = OverrideText(core, ROBOT, "m/s²").sentence(decision, Explainer(core).override(decision))

    assert decision.status is Status.RELAXED
    assert words.endswith(f"relaxed passivity by {decision.slack:.2g} W")


def test_disk_distance_is_first_order_and_h_without_slope() -> None:
    disk = barrier("disk", disk_keep_out(ROBOT.position, centre=(0.0, 0.0), radius=1.0))
    distance = BarrierDistance(derive_chain(ROBOT.system, disk), ROBOT)

    assert distance.is_obstacle
    assert distance.read(np.array([1.02, 0.0, 3.0, 1.0]), 0.0) == DistanceReading(
        value=pytest.approx(0.02, abs=0.02**2 / 2), unit="m"
    )
    assert distance.read(np.zeros(4), 0.0) == DistanceReading(value=-1.0, unit="")


def test_a_moving_obstacle_is_read_at_its_time() -> None:
    h = half_plane(ROBOT.position, normal=(1.0, 0.0), offset=-1.0) - ca.sin(ROBOT.system.t)
    distance = BarrierDistance(derive_chain(ROBOT.system, barrier("tide", h)), ROBOT)

    assert distance.read(np.zeros(4), pi / 2) == DistanceReading(value=pytest.approx(0.0, abs=1e-15), unit="m")


def emitter_of(core: SafetyPassivityFilter) -> OverrideEventEmitter:
    return OverrideEventEmitter(Explainer(core), OverrideText(core, ROBOT, "m/s²"), 100.0)


SOUTH = barrier("south", half_plane(ROBOT.position, normal=(0.0, 1.0), offset=-1.0))
CORE = core_of(wall("west", 1.0, -1.0), SOUTH)


def pushed(u_h: tuple[float, float]) -> Decision:
    return CORE.decide((-1.0, -1.0, 0.0, 0.0), REST, u_h, REST, start=True)


def test_notable_override_is_reported_once_per_set_of_causes() -> None:
    made = emitter_of(CORE)
    texts = [made.event(at * MS, pushed((-3.0, 0.0))) for at in range(0, 5000, 10)]

    [event] = [event for event in texts if event is not None]
    assert texts[0] is event
    assert (event.severity, event.text[:30]) == ("info", "held back 3 m/s²: obstacle `we")


def test_other_causes_are_reported_but_not_within_a_second() -> None:
    made = emitter_of(CORE)
    made.event(0, pushed((-3.0, 0.0)))

    assert made.event(EVENT_PERIOD_NS - 1, pushed((0.0, -3.0))) is None
    event = made.event(EVENT_PERIOD_NS, pushed((0.0, -3.0)))
    assert event is not None
    assert "`south`" in event.text


def test_same_causes_are_reported_again_after_a_pause() -> None:
    made = emitter_of(CORE)
    made.event(0, pushed((-3.0, 0.0)))

    assert made.event(REPEAT_AFTER_NS, pushed((-3.0, 0.0))) is None
    assert made.event(2 * REPEAT_AFTER_NS + 1, pushed((-3.0, 0.0))) is not None


def test_small_overrides_are_not_reported_and_not_rechecked_soon() -> None:
    made = emitter_of(CORE)

    assert made.event(0, pushed((3.0, 3.0))) is None
    assert made.event(CHECK_PERIOD_NS - 1, pushed((-3.0, 0.0))) is None
    assert made.event(CHECK_PERIOD_NS, pushed((-1.0, 30.0))) is None  # a thirtieth of what was asked for
    assert made.event(2 * CHECK_PERIOD_NS, pushed((-0.05, 0.0))) is None  # all of it, but next to nothing
    assert made.event(3 * CHECK_PERIOD_NS, pushed((-3.0, 0.0))) is not None


def test_the_fail_safe_law_is_not_explained() -> None:
    decision = CORE.decide((float("nan"), 0.0, 0.0, 0.0), REST, REST, REST)

    assert decision.status is Status.UNCERTIFIED
    assert emitter_of(CORE).event(0, decision) is None


def test_relaxation_is_a_warning() -> None:
    core = core_of(wall("a", 1.0, 0.01), wall("b", -1.0, 0.01))
    event = emitter_of(core).event(0, core.decide((0.0,) * 4, REST, REST, REST, start=True))

    assert event is not None
    assert event.severity == "warning"
