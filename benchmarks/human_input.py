"""Compares estimates of u_h and of its rate with the truth, ours and others'.

``python benchmarks/human_input.py``. Inputs of one axis in [-1, 1], known exactly; sampled irregularly, quantised,
delayed each for itself so that samples overtake one another, and stamped with the time at which they were asked for.
Errors are taken every 5 ms against the truth at that same time; that of φ = … + u̇_h + k_i (u_fb + u_h − u) is the
rate's plus k_i times that of u_h. Settings are chosen by ``--tune`` on other seeds.
"""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import product
from math import cos, exp, pi, sin, sqrt
from random import Random
from typing import Annotated, Any, Final, NamedTuple

import typer
from human_input_contenders import ENTRIES, STEP, Contender
from report import AsJson, Ratio, Report, Smallest

DURATION_S: Final = 10.0
LOOK_EVERY_S: Final = 0.005
RAMP_S: Final = 0.1
K_I: Final = 100.0
TUNING_SEED: Final = 10_000
OURS: Final = "passafe"

Signal = Callable[[float], tuple[float, float]]
"""u_h and its rate, as a function of time."""


class Errors(NamedTuple):
    """Of one contender on one kind of signal, all seeds together: u_h in units of u, the others in units of u per s."""

    value_rms: float
    value_worst: float
    rate_rms: float
    rate_worst: float
    phi_rms: float


class Sampling(NamedTuple):
    """Sampling of a signal: mean rate drawn for each trial from this range, every sample delayed by up to a time."""

    rate_min_hz: float
    rate_max_hz: float
    delay_max_s: float


class Trial(NamedTuple):
    """One signal as it was, and its samples in order of arrival: (arrival, asked for at, value)."""

    truth: list[tuple[float, float, float]]
    samples: list[tuple[float, float, float]]


def reaches(random: Random) -> Signal:
    """Return minimum-jerk reaches between random places, 0.3 to 1 s each, with rests (Flash & Hogan 1985)."""
    legs, t, place = [], 0.0, 0.0
    while t < DURATION_S:
        lasts_s, goal = random.uniform(0.3, 1.0), random.uniform(-1.0, 1.0)
        legs.append((t, lasts_s, place, goal - place))
        t, place = t + lasts_s + random.uniform(0.0, 0.5), goal

    def signal(t: float) -> tuple[float, float]:
        start_s, lasts_s, start, distance = next(leg for leg in reversed(legs) if leg[0] <= t)
        s = min((t - start_s) / lasts_s, 1.0)
        return start + distance * s**3 * (10 - 15 * s + 6 * s**2), distance * 30 * s**2 * (1 - s) ** 2 / lasts_s

    return signal


def multisine(random: Random) -> Signal:
    """Return the mean of five sines of 1 to 2 Hz with random phases, amplitude 1 each."""
    parts = [(2 * pi * random.uniform(1.0, 2.0), random.uniform(0.0, 2 * pi)) for _ in range(5)]
    return lambda t: (
        sum(sin(w * t + phase) for w, phase in parts) / 5,
        sum(w * cos(w * t + phase) for w, phase in parts) / 5,
    )


def keyboard(random: Random) -> Signal:
    """Return -1, 0 or 1 in turn for 0.15 to 1 s each, through the keyboard's own first-order ramp."""
    legs, t, u, target = [], 0.0, 0.0, 0.0
    while t < DURATION_S:
        lasts_s, target = (
            random.uniform(0.15, 1.0),
            random.choice([goal for goal in (-1.0, 0.0, 1.0) if goal != target]),
        )
        legs.append((t, u, target))
        t, u = t + lasts_s, target + (u - target) * exp(-lasts_s / RAMP_S)

    def signal(t: float) -> tuple[float, float]:
        start_s, start, target = next(leg for leg in reversed(legs) if leg[0] <= t)
        left = (start - target) * exp((start_s - t) / RAMP_S)
        return target + left, -left / RAMP_S

    return signal


SIGNALS: Final = {"minimum-jerk reaches": reaches, "multisine 1-2 Hz": multisine, "keyboard": keyboard}


def trial(kind: str, seed: int, sampling: Sampling) -> Trial:
    """Return one signal and its samples, at intervals that vary by ±30 %."""
    random = Random(f"{kind} {seed}")  # noqa: S311 - seeded on purpose
    signal, rate_hz = SIGNALS[kind](random), random.uniform(sampling.rate_min_hz, sampling.rate_max_hz)
    samples, t = [], 0.0
    while t < DURATION_S:
        samples.append((t + random.uniform(0.0, sampling.delay_max_s), t, STEP * round(signal(t)[0] / STEP)))
        t += random.uniform(0.7, 1.3) / rate_hz
    looks = [LOOK_EVERY_S * i for i in range(round(0.5 / LOOK_EVERY_S), round(DURATION_S / LOOK_EVERY_S))]
    return Trial([(t, *signal(t)) for t in looks], sorted(samples))


def errors_of(make: Callable[[], Contender], trials: list[Trial]) -> Errors:
    """Return the errors over all trials."""
    value, rate, phi = [], [], []
    for truth, samples in trials:
        contender, coming = make(), iter(samples)
        arrival_s, asked_s, sample = next(coming)
        for t, u, u_rate in truth:
            while arrival_s <= t:
                contender.add(asked_s, sample)
                arrival_s, asked_s, sample = next(coming, (1e9, 0.0, 0.0))
            u_hat, rate_hat = contender.at(t)
            value.append(abs(u_hat - u))
            rate.append(abs(rate_hat - u_rate))
            phi.append(rate_hat - u_rate + K_I * (u_hat - u))
    return Errors(_rms(value), max(value), _rms(rate), max(rate), _rms(phi))


def _rms(numbers: list[float]) -> float:
    return sqrt(sum(number * number for number in numbers) / len(numbers))


def tuned(name: str, seeds: int, sampling: Sampling) -> tuple[float, dict[str, Any]]:
    """Return the settings with the least sum of RMS errors, each relative to holding, and that sum."""
    sets = [[trial(kind, TUNING_SEED + i, sampling) for i in range(seeds)] for kind in SIGNALS]
    held = [errors_of(ENTRIES["hold, rate 0"].make, trials) for trials in sets]

    def score(settings: dict[str, Any]) -> float:
        got = [errors_of(partial(ENTRIES[name].make, **settings), trials) for trials in sets]
        return sum(g.value_rms / h.value_rms + g.rate_rms / h.rate_rms for g, h in zip(got, held, strict=True))

    return min(((score(each), each) for each in _choices(name)), key=lambda pair: pair[0])


def _choices(name: str) -> Iterator[dict[str, Any]]:
    choices = ENTRIES[name].choices
    for values in product(*choices.values()):
        yield dict(zip(choices, values, strict=True))


def main(
    seeds: Annotated[int, typer.Option(min=1, max=1000, help="Trials of each kind of signal.")] = 20,
    first_seed: Annotated[int, typer.Option(min=0, max=TUNING_SEED - 1000)] = 1,
    delay_max_s: Annotated[float, typer.Option(min=0.0, max=1.0, help="Largest delay of a sample, s.")] = 0.1,
    rate_min_hz: Annotated[float, typer.Option(min=1.0, max=2000.0, help="Least mean rate, Hz.")] = 20.0,
    rate_max_hz: Annotated[float, typer.Option(min=1.0, max=2000.0, help="Largest mean rate, Hz.")] = 100.0,
    tune: Annotated[bool, typer.Option(help="Choose settings anew instead, on seeds of its own.")] = False,
    only: Annotated[str, typer.Option(help="Contenders whose name contains this.")] = "",
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Compare estimators of the operator's input with the truth."""
    if smallest:
        seeds = 1
    names = [name for name in ENTRIES if only in name]
    sampling = Sampling(rate_min_hz, rate_max_hz, delay_max_s)
    if tune:
        for name in names:
            score, settings = tuned(name, min(seeds, 4), sampling)
            print(f"{name}: {score:.3f} {settings}")
        return
    report = Report(
        title=f"Estimates of u_h in -1 to 1, {seeds} trials of {DURATION_S:g} s a signal, from seed {first_seed}, "
        f"{rate_min_hz:g} to {rate_max_hz:g} Hz, delay up to {delay_max_s:g} s, quantised to {STEP:g}",
        columns=("estimator", "signal", "u_h RMS", "worst", "rate RMS, 1/s", "worst, 1/s", "φ RMS, 1/s"),
    )
    phi_rms: dict[str, list[float]] = {name: [] for name in names}
    for kind in SIGNALS:
        trials = [trial(kind, first_seed + i, sampling) for i in range(seeds)]
        for name in names:
            errors = errors_of(partial(ENTRIES[name].make, **ENTRIES[name].chosen), trials)
            phi_rms[name].append(errors.phi_rms)
            report.rows.append((name, kind, *(f"{number:.3f}" for number in errors)))
    report.notes.append("ratios: φ RMS, median, least and most over the kinds of signal")
    for name in names:
        if name != OURS and OURS in names:
            report.ratios.append(Ratio.of_rounds(name, phi_rms[name], OURS, phi_rms[OURS]))
    report.finish(as_json=as_json)


if __name__ == "__main__":
    typer.run(main)
