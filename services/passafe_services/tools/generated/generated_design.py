"""A design from a seed, and what is known of it without the filter."""

from dataclasses import dataclass
from typing import Final

import casadi as ca
import numpy as np

from passafe.barrier_chain import Barrier
from passafe.class_k import Linear
from passafe.design import FilterDesign, Mode
from passafe.numerics.workspace import Array
from passafe.passivity import Passivity
from passafe.tank import Tank
from passafe_services.tools.generated.admissible_input import AdmissibleInput, InputLimits
from passafe_services.tools.generated.design_timing import GAINS_PER_S, DesignTiming
from passafe_services.tools.generated.families import FAMILIES
from passafe_services.tools.generated.generated_plant import GeneratedPlant
from passafe_services.tools.generated.protected_set import ProtectedSet, RandomChain, draw_gains
from passafe_services.tools.generated.random_numbers import chance, log_uniform, one_of

STREAM: Final = 0x6E3E
"""First part of the seed of every design's generator."""

ORACLE_STATES: Final = {True: 1000, False: 100}
"""States in which the oracle is asked, by whether f is affine in u: a grid costs more than a polygon."""

TIGHTEST, LOOSEST = 0.3, 30.0
"""Limits as multiples of what the rows ask for at most in random states: below one they are too tight."""

SHARE_WITH_GATEKEEPER: Final = 0.25

LEAST_INPUT: Final = 0.2
"""Least limit, in units of the plant's input scale."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class GeneratedDesign:
    """A design and its surroundings.

    Attributes:
        seed: What it was made from.
        family: Name of the plant's family.
        plant: The plant.
        timing: Its period, hold and gains.
        chains: Of its barriers.
        limits: As they were drawn.
        mode: What is enforced.
        tank: The tank; ``None`` without one.
        k_i: α/2, 1/s.
        oracle_share: Share of random states in the protected set in which some admissible input keeps all rows; NaN
            without such a state.
        gatekeeper: Whether it is to have a gatekeeper, if the fail-safe law keeps every barrier from its start.
    """

    seed: int
    family: str
    plant: GeneratedPlant
    timing: DesignTiming
    chains: tuple[RandomChain, ...]
    limits: InputLimits
    mode: Mode
    tank: Tank | None
    k_i: float
    oracle_share: float
    gatekeeper: bool

    @classmethod
    def of(cls, seed: int) -> "GeneratedDesign":
        """Draw the design of a seed."""
        family = list(FAMILIES)[seed % len(FAMILIES)]
        rng = np.random.default_rng([STREAM, seed])
        timing = DesignTiming.draw(rng)
        plant = FAMILIES[family](rng, timing)
        chains = tuple(
            RandomChain.of(
                plant.system,
                offer,
                draw_gains(rng, offer.degree, timing.largest_gain_per_s, GAINS_PER_S[0]),
                timing.held_s,
            )
            for offer in plant.barriers
        )
        is_affine = plant.is_affine
        oracle = AdmissibleInput(plant.system, chains, plant.input_scale, affine=is_affine)
        protected = ProtectedSet(plant, chains)
        everywhere, shrunk = protected.draw(rng, smallest=1.0)[0], protected.draw(rng)[0]
        states = np.concatenate([everywhere, shrunk], axis=1)[:, : ORACLE_STATES[is_affine]]
        limits = _draw_limits(rng, plant, timing, oracle.demand(states) if is_affine else None)
        mode = Mode.BOTH if chance(rng, 0.4) else Mode.SAFE
        return cls(
            seed=seed,
            family=family,
            plant=plant,
            timing=timing,
            chains=chains,
            limits=limits,
            mode=mode,
            tank=_draw_tank(rng, plant) if mode is Mode.BOTH and chance(rng, 0.7) else None,
            k_i=log_uniform(rng, 0.05, 0.95) / timing.dt_s,
            gatekeeper=chance(np.random.default_rng([STREAM, seed, 1]), SHARE_WITH_GATEKEEPER),
            oracle_share=float(oracle.exists(states, limits).mean()) if states.size else float("nan"),
        )

    @property
    def is_feasible(self) -> bool:
        """True if the oracle found an admissible input in every state that it was asked about."""
        return self.oracle_share == 1.0

    def filter_design(self, *, gatekeeper: bool = False) -> FilterDesign:
        """Return what the filter is derived from.

        Args:
            gatekeeper: Whether it has a gatekeeper.

        Raises:
            DesignError: The core refuses a part of it.
        """
        plant, limits = self.plant, self.limits
        return FilterDesign(
            system=plant.system,
            u_fb=plant.feedback,
            fail_safe=plant.fail_safe,
            barriers=tuple(
                Barrier(name=chain.offer.name, h=chain.offer.h, class_k=tuple(Linear(gain=g) for g in chain.gains))
                for chain in self.chains
            ),
            passivity=Passivity(V=plant.storage, tank=self.tank),
            k_i=self.k_i,
            dt_s=self.timing.dt_s,
            hold_s=self.timing.hold_s,
            input_bound=limits.magnitude,
            input_norm_bound=limits.norm,
            input_rate_bound_per_s=limits.rate_per_s,
            mode=self.mode,
            gatekeeper=gatekeeper,
        )


def _draw_limits(
    rng: np.random.Generator, plant: GeneratedPlant, timing: DesignTiming, demand: Array | None
) -> InputLimits:
    """Draw limits around what the rows ask for, or around the plant's input scale where that is not known."""
    scale = np.array(plant.input_scale)
    asked = 1.0
    if demand is not None and np.isfinite(demand).any():
        asked = float(demand[np.isfinite(demand)].max())
    elif demand is None:
        asked = 0.5
    magnitude = scale * max(asked * log_uniform(rng, TIGHTEST, LOOSEST), LEAST_INPUT)
    if plant.largest_input is not None:
        magnitude = np.minimum(magnitude, plant.largest_input)
    norm = float(magnitude.max()) * rng.uniform(0.7, 1.3) if len(scale) > 1 and chance(rng, 0.25) else None
    rate = magnitude / log_uniform(rng, timing.dt_s, 1.0) if chance(rng, 0.25) else None
    return InputLimits(
        magnitude=tuple(magnitude.tolist()), norm=norm, rate_per_s=None if rate is None else tuple(rate.tolist())
    )


def _draw_tank(rng: np.random.Generator, plant: GeneratedPlant) -> Tank:
    """Draw a tank that holds about what the plant does in a corner of its box."""
    system = plant.system
    stored = ca.Function("stored", [system.x], [plant.storage])
    swing = abs(float(stored(ca.DM(plant.high))) - float(stored(ca.DM(plant.low) * 0)))
    initial_j = max(swing, 1e-3) * log_uniform(rng, 0.05, 2.0)
    return Tank(
        initial_j=initial_j,
        reserve_j=initial_j * one_of(rng, (0.0, 0.2, 0.5)),
        max_j=initial_j * rng.uniform(1.0, 5.0),
        rate_per_s=log_uniform(rng, 1.0, 20.0),
    )
