"""Reports a benchmark: one table and ratios of what was measured side by side, printed or as JSON."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from math import isfinite
from statistics import median
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of the table.")]
States = Annotated[int, typer.Option(min=10, max=5000, help="States along the closed loop.")]
Rounds = Annotated[int, typer.Option(min=1, max=200, help="Rounds.")]
Smallest = Annotated[bool, typer.Option("--smallest", help="Measure next to nothing: does it run, do answers agree?")]


@dataclass(frozen=True, kw_only=True, slots=True)
class Ratio:
    """Quotient of two quantities measured side by side.

    Attributes:
        of: Name of the dividend.
        over: Name of the divisor.
        median: Over all rounds.
        least: Over all rounds.
        most: Over all rounds.
    """

    of: str
    over: str
    median: float
    least: float
    most: float

    @classmethod
    def of_rounds(cls, of: str, dividends: Sequence[float], over: str, divisors: Sequence[float]) -> "Ratio":
        """Return the ratio of two quantities measured in the same rounds."""
        each = [dividend / divisor for dividend, divisor in zip(dividends, divisors, strict=True)]
        return cls(of=of, over=over, median=median(each), least=min(each), most=max(each))

    def __str__(self) -> str:
        spread = "" if self.least == self.most else f" ({self.least:.2f} to {self.most:.2f})"
        return f"{self.of} / {self.over} = {self.median:.2f}{spread}"


@dataclass(kw_only=True, slots=True)
class Report:
    """Results of one benchmark.

    Attributes:
        title: Heading with the size of the measurement.
        columns: Headings of the table.
        rows: Cells of the table.
        ratios: What the benchmark is run for.
        notes: Sentences below the table.
        failures: Checks that failed; any ends the process with exit code 1.
    """

    title: str
    columns: tuple[str, ...]
    rows: list[tuple[str, ...]] = field(default_factory=list)
    ratios: list[Ratio] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    def finish(self, *, as_json: bool) -> None:
        """Print the report.

        Raises:
            typer.Exit: With code 1, if a check failed or a ratio is no number.
        """
        self.failures += [
            f"ratio: got {ratio}, allowed a number" for ratio in self.ratios if not isfinite(ratio.median)
        ]
        if as_json:
            print(json.dumps(asdict(self), indent=2, ensure_ascii=False))
        else:
            self._print()
        if self.failures:
            raise typer.Exit(1)

    def _print(self) -> None:
        table = Table(title=self.title)
        for i, column in enumerate(self.columns):
            table.add_column(column, justify="right" if i else "left")
        for row in self.rows:
            table.add_row(*row)
        console = Console(width=max(130, Console().width), highlight=False)
        console.print(table)
        for line in [*map(str, self.ratios), *self.notes]:
            console.print(line, markup=False)
        for failure in self.failures:
            console.print(f"failed: {failure}", style="bold red", markup=False)


def spread(values: Sequence[float], decimals: int = 1) -> str:
    """Return median, least and largest of a quantity's rounds as text."""
    middle = f"{median(values):.{decimals}f}"
    return middle if len(values) == 1 else f"{middle} ({min(values):.{decimals}f} to {max(values):.{decimals}f})"
