"""Changes of the core, one thing at a time: what ``mutation.py`` tries.

A plus for a minus, a minus sign left out, a row left out, a gain or a period halved, a least for a largest.
"""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[1]
FILES: Final = tuple(str(path.relative_to(ROOT / "passafe")) for path in sorted((ROOT / "passafe").rglob("*.py")))
"""Every file of the core."""

GAINS: Final = frozenset({"gain", "gain_below", "k_i", "dt_s", "rate_per_s", "reserve_j", "slack_price", "norm"})
_PAIRS: Final = (("fmin", "fmax"), ("mmin", "mmax"), ("min", "max"), ("minimum", "maximum"), ("argmin", "argmax"))
SWAPPED: Final = dict(_PAIRS) | {largest: least for least, largest in _PAIRS}

_STATES: Final = "scale * ca.DM([(0.37 + 0.11 * k + 0.29 * i) * (-1) ** (i + k) for i in range(system.n)])"
_TOUCHED: Final = "if program.norm < inf:  # where it binds, the best input is near the answer or where the pull ends"
_FROM: Final = "self._linear[:m], self._linear[m] = known * -scale, -lower * scale - 1 / ETA"
_ROOT: Final = "root = max((sqrt(row.slack_price) for row in rows if row.slack_price is not None), default=0.0)"
_LEAST: Final = "ca.if_else(always, -inf, ca.if_else(some, (b - root) / a, inf)),"
_MOST: Final = "ca.if_else(always, inf, ca.if_else(some, (b + root) / a, -inf)),"
_INFINITE: Final = "what is infinite has an infinite half, what is not has not"
_PROBES: Final = "the states and inputs at which a gradient is looked at are in general position either way"
EQUIVALENT: Final[dict[tuple[str, str, str], str]] = {
    ("barrier.py", _STATES, "0.37 + 0.11 * k + 0.29 * i: -"): _PROBES,
    ("barrier.py", _STATES, "0.37 + 0.11 * k: -"): _PROBES,
    ("barrier.py", _STATES, "i + k: -"): "(−1)^(i−k) is (−1)^(i+k)",
    ("barrier.py", "inputs = ca.DM([0.53 + 0.17 * j for j in range(system.m)])", "0.53 + 0.17 * j: -"): _PROBES,
    ("infeasibility.py", "if self.norm == inf:", "self.norm: halved"): _INFINITE,
    ("infeasibility.py", "if program.norm == inf:", "program.norm: halved"): _INFINITE,
    ("infeasibility.py", _TOUCHED, "program.norm: halved"): _INFINITE,
    ("least_violation.py", "length = sqrt(1 + ETA)", "1 + ETA: -"): "all of a row has this factor",
    ("override.py", _LEAST, "-inf: no minus"): "a request without a command that keeps all is not overridden",
    ("override.py", _MOST, "-inf: no minus"): "the least is inf, which alone says that there is none",
    ("rows.py", _ROOT, f"{_ROOT.removeprefix('root = ')}: min"): "one row is soft at most",
    ("infeasibility.py", _FROM, "-lower: no minus"): "1/η is 1e8 times larger, so where t starts is lost in rounding",
}
"""Changes that change nothing that anybody could see, by file, line and words, with the reason."""


@dataclass(frozen=True, kw_only=True)
class Change:
    """One change of one file.

    Attributes:
        file: Name of the core's file.
        line: Where, from 1.
        source: The line as it is.
        what: In words.
        text: The whole file with the change.
    """

    file: str
    line: int
    source: str
    what: str
    text: str

    @property
    def key(self) -> str:
        """Name of the change that tells it from others, and from the same one of another version of the file."""
        return f"{self.file}:{self.line} {self.what} {sha256(self.text.encode()).hexdigest()[:16]}"

    @property
    def is_equivalent(self) -> bool:
        """Whether it is known to change nothing."""
        return (self.file, self.source, self.what) in EQUIVALENT


def changes_of(file: str) -> Iterator[Change]:
    """Yield every change of one file."""
    source = (ROOT / "passafe" / file).read_text(encoding="utf-8")
    lines, starts = source.splitlines(keepends=True), [0]
    for line in lines:
        starts.append(starts[-1] + len(line.encode()))
    raw = source.encode()
    for node in ast.walk(ast.parse(source)):
        for what, replacement in _replacements(node):
            place: int = node.lineno  # type: ignore[attr-defined]  # every one has a place
            begin = starts[place - 1] + node.col_offset  # type: ignore[attr-defined]
            end = starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]
            text = (raw[:begin] + replacement.encode() + raw[end:]).decode()
            yield Change(file=file, line=place, source=lines[place - 1].strip(), what=what, text=text)


def _replacements(node: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield what may be put in the place of a node: words for it, and source."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.Add | ast.Sub):
        sign = "-" if isinstance(node.op, ast.Add) else "+"
        if isinstance(node, ast.AugAssign):
            changed = f"{ast.unparse(node.target)} {sign}= {ast.unparse(node.value)}"
        else:
            changed = f"({ast.unparse(node.left)} {sign} ({ast.unparse(node.right)}))"
        yield f"{ast.unparse(node)}: {sign}", changed
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
        yield f"{ast.unparse(node)}: no minus", f"({ast.unparse(node.operand)})"
    is_number = isinstance(node, ast.Attribute) and node.attr in GAINS and ast.unparse(node) != "np.linalg.norm"
    if is_number and isinstance(node.ctx, ast.Load):
        yield f"{ast.unparse(node)}: halved", f"(0.5 * {ast.unparse(node)})"
    if isinstance(node, ast.Call):
        yield from _replacements_of_call(node)


def _replacements_of_call(node: ast.Call) -> Iterator[tuple[str, str]]:
    arguments = ", ".join(ast.unparse(argument) for argument in [*node.args, *node.keywords])
    if isinstance(node.func, ast.Attribute) and node.func.attr in SWAPPED:
        other = f"{ast.unparse(node.func.value)}.{SWAPPED[node.func.attr]}"
        yield f"{ast.unparse(node)}: {SWAPPED[node.func.attr]}", f"{other}({arguments})"
    if isinstance(node.func, ast.Name) and node.func.id in SWAPPED:
        yield f"{ast.unparse(node)}: {SWAPPED[node.func.id]}", f"{SWAPPED[node.func.id]}({arguments})"
    if isinstance(node.func, ast.Attribute) and node.func.attr == "append":
        yield f"{ast.unparse(node)}: left out", "None"
