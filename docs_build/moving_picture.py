"""Draw the README's moving picture: four modes of the filter side by side, from logs.

``python docs_build/moving_picture.py docs/pictures/four-modes.gif`` simulates the reference scenario in each mode and
draws its log; the same command gives the same picture.
"""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray
from passafe_protocol.messages import FilterTick, PlantState
from passafe_services.tools.review.run_log import RunLog
from PIL import Image

MODES: Final = {
    "off": "no filter",
    "passive": "passive",
    "safe": "safe",
    "both": "safe and passive",
}
FRAMES_PER_S: Final = 12
SHOWN_S: Final = 6.0
PAUSE_MS: Final = 2500
"""How long the last frame stands."""

WIDTH_IN, HEIGHT_IN, DPI = 9.0, 3.3, 100
COLOURS: Final = 64
TOLERANCE_W: Final = 0.01
"""Power below which a run counts as generating none; the sampled law leaves 1e-4 W in this one."""

TARGET: Final = (-0.3, 0.0)
GOOD, BAD, GREY = "#1b7f5c", "#c62828", "#90a4ae"

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Run:
    """One run on the grid of frames: times (k,) s, positions (k, 2) m, h (k,) m² and power margin (k,) W."""

    time_s: Array
    position: Array
    h: Array
    power_margin_w: Array

    @classmethod
    def of(cls, path: Path, time_s: Array) -> "Run":
        """Sample a log at ``time_s``; h and the power margin keep the lowest value since the frame before."""
        log = RunLog.read(path)
        states = sorted((message.body.plant_ns / 1e9, message.body.x) for message in log.of(PlantState))
        ticks = sorted(
            (message.body.effective_plant_ns / 1e9, message.body.barriers[0].psi[0], message.body.power_margin)
            for message in log.of(FilterTick)
        )
        when = np.array([moment for moment, _ in states])
        x = np.array([state[:2] for _, state in states])
        tick_s, h, margin = np.array(ticks).T
        edges = np.searchsorted(tick_s, time_s)
        spans = [slice(max(0, start - 1), max(start, end)) for start, end in zip([0, *edges[:-1]], edges, strict=True)]
        return cls(
            time_s=time_s,
            position=np.stack([np.interp(time_s, when, column) for column in x.T], axis=1),
            h=np.array([h[span].min(initial=np.inf) for span in spans]),
            power_margin_w=np.array([margin[span].min(initial=np.inf) for span in spans]),
        )


class Panel:
    """One mode: the robot seen from above, and two lines of text: safe so far, passive so far."""

    def __init__(self, axes: Axes, title: str, run: Run) -> None:
        self._run = run
        axes.set(xlim=(-1.6, 2.4), ylim=(-1.5, 2.4), aspect="equal", xticks=[], yticks=[])
        axes.set_title(title, fontsize=12)
        axes.add_patch(Circle((0, 0), 1.0, facecolor="#eceff1", edgecolor="#455a64", linewidth=1.2))
        axes.plot(*TARGET, marker="x", color="#455a64", markersize=7)
        (self._path,) = axes.plot([], [], color=GREY, linewidth=1.6)
        (self._robot,) = axes.plot([], [], marker="o", markersize=9, color=GOOD)
        self._words = [axes.text(-1.5, place, "", fontsize=10, va="center") for place in (-1.72, -2.07)]
        for words in self._words:
            words.set_clip_on(False)

    def draw(self, frame: int) -> None:
        """Move to a frame."""
        run, shown = self._run, slice(0, frame + 1)
        h, margin = run.h[shown].min(), run.power_margin_w[shown].min()
        self._path.set_data(*run.position[shown].T)
        self._robot.set_data(*run.position[frame : frame + 1].T)
        self._robot.set_color(BAD if run.h[frame] < 0 else GOOD)
        safe, passive = h >= 0, margin >= -TOLERANCE_W
        self._words[0].set_text("stays outside the disk" if safe else "enters the disk")
        self._words[1].set_text("generates no energy" if passive else "generates energy")
        for words, good in zip(self._words, (safe, passive), strict=True):
            words.set_color(GOOD if good else BAD)


def draw(runs: dict[str, Run], target: Path) -> None:
    """Write the animation."""
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), dpi=DPI)
    panels = [
        Panel(figure.add_subplot(1, len(runs), number), MODES[mode], run)
        for number, (mode, run) in enumerate(runs.items(), start=1)
    ]
    figure.subplots_adjust(left=0.01, right=0.99, top=0.81, bottom=0.17, wspace=0.06)
    figure.suptitle("The same operator pushes the robot towards the cross, through four filters", fontsize=12, y=0.98)
    last = len(next(iter(runs.values())).time_s) - 1
    canvas = FigureCanvasAgg(figure)
    frames = []
    for frame in range(last + 1):
        for panel in panels:
            panel.draw(frame)
        frames.append(_image(canvas))
    palette = frames[last].quantize(COLOURS)
    pictures = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    duration_ms = [round(1000 / FRAMES_PER_S)] * last + [PAUSE_MS]
    pictures[0].save(target, save_all=True, append_images=pictures[1:], duration=duration_ms, loop=0, optimize=True)


def main(arguments: list[str]) -> int:
    """Simulate, draw, and return the exit code."""
    if len(arguments) != 1:
        sys.stderr.write("usage: python docs_build/moving_picture.py PICTURE.gif\n")
        return 2
    time_s = np.arange(round(SHOWN_S * FRAMES_PER_S) + 1) / FRAMES_PER_S
    with TemporaryDirectory() as folder:
        runs = {mode: Run.of(_simulated(mode, Path(folder)), time_s) for mode in MODES}
    draw(runs, Path(arguments[0]))
    return 0


def _simulated(mode: str, folder: Path) -> Path:
    log = folder / f"{mode}.mcap"
    command = [sys.executable, "-P", "-m", "passafe_services.cli", "simulate", "--mode", mode, "--out", str(log)]
    # A run without the filter violates its properties, which is what the picture shows: no check of the exit code.
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL)  # noqa: S603 - ours
    return log


def _image(canvas: FigureCanvasAgg) -> Image.Image:
    canvas.draw()
    return Image.frombytes("RGBA", canvas.get_width_height(), bytes(canvas.buffer_rgba())).convert("RGB")


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
