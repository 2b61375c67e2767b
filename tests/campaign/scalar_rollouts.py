"""A rollout written a second time: one filter, one plant, one operator, tick by tick."""

from collections import Counter
from collections.abc import Callable
from math import cos, pi

import numpy as np
from passafe_services.scenarios.design import design_of, robot_of, sampled_plant_of, tank_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.campaign.rollout_result import RolloutResult
from passafe_services.tools.campaign.safe_starts import SafeStarts
from passafe_services.tools.review.core_evaluator import CoreEvaluator

from passafe.decision import ANSWERS, Decision
from passafe.filter import SafetyPassivityFilter
from passafe.numerics.workspace import Array

NAMES = ("piecewise-constant", "chirp", "bang-bang", "against-h", "against-the-tank")
STRENGTH = 20.0
Ask = Callable[[float, Decision | None], Array]


def adversary(name: str, rng: np.random.Generator, m: int) -> Ask:
    if name == "piecewise-constant":
        held = {"until": 0.0, "u_h": np.zeros(m)}

        def piecewise(t: float, _: Decision | None) -> Array:
            if t >= held["until"]:
                held["until"] = t + rng.exponential(1.0)
                held["u_h"] = rng.uniform(-STRENGTH, STRENGTH, m)
            return np.asarray(held["u_h"])

        return piecewise
    if name == "chirp":
        amplitude, phase, rate = rng.uniform(5.0, STRENGTH, m), rng.uniform(0, 2 * pi, m), np.log(500.0) / 10.0
        return lambda t, _: amplitude * np.cos(2 * pi * 0.1 * (np.exp(rate * t) - 1) / rate + phase)
    if name == "bang-bang":
        period = float(np.exp(rng.uniform(np.log(0.02), 0.0)))
        return lambda t, seen: (1.0 if cos(2 * pi * t / period) > 0 else -1.0) * STRENGTH * into_tightest(seen, m)
    if name == "against-h":
        return lambda _, seen: STRENGTH * into_tightest(seen, m)
    return lambda _, seen: STRENGTH * into_passivity(seen, m)


def rows(decision: Decision, m: int) -> tuple[Array, Array, int]:
    G = decision.part("G").reshape((decision.part("d").size, -1), order="F")[:, :m]
    return G, decision.margins[: len(G)], decision.part("relax").size


def scaled(row: Array, m: int) -> Array:
    size = np.abs(row).max(initial=0.0)
    return row / size if size > 0 else np.eye(1, m)[0]


def into_tightest(seen: Decision | None, m: int) -> Array:
    if seen is None:
        return np.eye(1, m)[0]
    G, margins, hard = rows(seen, m)
    alike = np.flatnonzero(margins[:hard] <= margins[:hard].min(initial=np.inf) + 1e-5)
    return scaled(-G[alike[0]] if hard else np.zeros(m), m)


def into_passivity(seen: Decision | None, m: int) -> Array:
    if seen is None:
        return np.eye(1, m)[0]
    G, _, hard = rows(seen, m)
    return scaled(-G[-1] if len(G) > hard else np.zeros(m), m)


def rollout(scenario: Scenario, seed: int, duration_s: float) -> RolloutResult:
    """Roll out one state at a time, without batching."""
    robot = robot_of(scenario)
    core = SafetyPassivityFilter(design_of(scenario, robot))
    plant, tank, evaluator = sampled_plant_of(scenario, robot), tank_of(scenario), CoreEvaluator(scenario)
    rng, m, dt_s = np.random.default_rng([seed, 0x9A55AFE]), robot.system.m, scenario.dt_s
    name = NAMES[seed % 5]
    ask = adversary(name, rng, m)
    sample, level_j = plant.at(SafeStarts(scenario, core).draw(rng).tolist()), tank.initial_j
    decision, u, levels, beyond, unproven = None, (0.0,) * m, [level_j], [-np.inf], 0
    xs, us, statuses = [], [], Counter[str]()
    for k in range(round(duration_s / dt_s)):
        before, u_h = u, ask(k * dt_s, decision)
        decision = core.decide(sample.x, u, u_h.tolist(), (0.0,) * m, level_j, k * dt_s, start=k == 0)
        u, stored_j = decision.u, sample.stored_j
        statuses[decision.status.name] += 1
        late = decision.part("shortfall")[0] > 0 or decision.part("outside_trust_region")[0] > 0
        unproven += late and decision.status in ANSWERS
        beyond += overreaches(core, np.array(u), None if k == 0 else np.array(before))
        xs.append(sample.x)
        us.append(u)
        sample = plant.advance(sample.x, u)
        level_j = tank.balance(level_j, sample.energy_in_j, sample.stored_j - stored_j)
        levels.append(level_j)
    x, held, t_s = np.array(xs).T, np.array(us).T, np.arange(len(xs)) * dt_s
    h = [evaluator.h(evaluator.flow(x, held, dt_s * j / 4), t_s + dt_s * j / 4) for j in (1, 2, 3, 4)]
    h.append(evaluator.h(x, t_s))
    return RolloutResult(
        seed=seed,
        adversary=name,
        h_min=min((float(each.min(initial=np.inf)) for each in h), default=np.inf),
        tank_min_j=min(levels),
        overreach=float(max(beyond)),
        ticks=len(xs),
        statuses=dict(statuses),
        between_samples_unproven=unproven,
        decided_scalar=len(xs),
    )


def overreaches(core: SafetyPassivityFilter, u: Array, before: Array | None) -> list[float]:
    limits, dt_s = core.design.limits, core.design.dt_s
    found = [float((np.abs(u) - limits.magnitude).max())]
    if limits.norm is not None:
        found.append(float(np.linalg.norm(u)) - limits.norm)
    if limits.rise_per_s is not None and before is not None:
        found.append(float((np.abs(u - before) - dt_s * np.array(limits.rise_per_s)).max()))
    return found
