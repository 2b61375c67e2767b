"""Generates the changes of the core that ``mutation.py`` tries, one thing at a time.

A plus for a minus, a minus sign left out, a row left out, a gain or a period halved, a minimum for a maximum.
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

_PROBES: Final = "the states and inputs at which a gradient is looked at are in general position either way"
EQUIVALENT: Final[dict[tuple[str, str], str]] = {
    ("_general_states", "0.37 + 0.11 * k + 0.29 * i: -"): _PROBES,
    ("_general_states", "0.37 + 0.11 * k: -"): _PROBES,
    ("_positive_states", "0.37 + 0.11 * k: -"): _PROBES,
    ("_gradients", "0.53 + 0.17 * j: -"): _PROBES,
    ("_general_states", "i + k: -"): "(−1)^(i−k) is (−1)^(i+k)",
    (
        "_within",
        "-inf: no minus",
    ): "a request without a command is not overridden; where no q is allowed, the least is inf",
    (
        "DistanceToInfeasibility._refine",
        "-lower: no minus",
    ): "1/η is 1e8 times larger: where t starts is lost in rounding",
    ("", "1 + ETA: -"): "all of a row has this factor",
    (
        "stack",
        "max((sqrt(row.slack_price) for row in rows if row.slack_price is not None), default=0.0): min",
    ): "one row is soft at most",
}
"""Changes without any visible effect, by function and words, with the reason; lines and files may move."""


@dataclass(frozen=True, kw_only=True)
class Change:
    """One change of one file.

    Attributes:
        file: Name of the core's file.
        line: Where, from 1.
        scope: Function or class that the change is in, by its qualified name; empty at the level of the module.
        words: The expression as it is, and what becomes of it.
        text: The whole file with the change.
    """

    file: str
    line: int
    scope: str
    words: str
    text: str

    @property
    def key(self) -> str:
        """Name of the change that tells it from others, and from the same one of another version of the file."""
        return f"{self.file}:{self.line} {self.words} {sha256(self.text.encode()).hexdigest()[:16]}"

    @property
    def is_equivalent(self) -> bool:
        """True if the change is known to have no visible effect."""
        return (self.scope, self.words) in EQUIVALENT


def changes_of(file: str) -> Iterator[Change]:
    """Yield every change of one file."""
    source = (ROOT / "passafe" / file).read_text(encoding="utf-8")
    lines, starts = source.splitlines(keepends=True), [0]
    for line in lines:
        starts.append(starts[-1] + len(line.encode()))
    raw = source.encode()
    for scope, node in _nodes(ast.parse(source), ""):
        for words, replacement in _replacements(node):
            begin = starts[node.lineno - 1] + node.col_offset
            end = starts[(node.end_lineno or node.lineno) - 1] + (node.end_col_offset or 0)
            text = (raw[:begin] + replacement.encode() + raw[end:]).decode()
            yield Change(file=file, line=node.lineno, scope=scope, words=words, text=text)


def _nodes(parent: ast.AST, scope: str) -> Iterator[tuple[str, ast.expr | ast.stmt]]:
    """Yield every expression and statement below a node, with the qualified name of what it is in."""
    for node in ast.iter_child_nodes(parent):
        if isinstance(node, ast.expr | ast.stmt) and not _is_compared_with_inf(parent):
            yield scope, node
        inside = scope
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            inside = f"{scope}.{node.name}" if scope else node.name
        yield from _nodes(node, inside)


def _is_compared_with_inf(parent: ast.AST) -> bool:
    """Return whether a node's parts are compared with infinity: what is infinite has an infinite half."""
    return isinstance(parent, ast.Compare) and any(ast.unparse(each) == "inf" for each in parent.comparators)


def _replacements(node: ast.expr | ast.stmt) -> Iterator[tuple[str, str]]:
    """Yield replacements of a node: words for it, and source."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.Add | ast.Sub):
        sign = "-" if isinstance(node.op, ast.Add) else "+"
        if isinstance(node, ast.AugAssign):
            changed = f"{ast.unparse(node.target)} {sign}= {ast.unparse(node.value)}"
        else:
            changed = f"({ast.unparse(node.left)} {sign} ({ast.unparse(node.right)}))"
        yield f"{ast.unparse(node)}: {sign}", changed
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
        yield f"{ast.unparse(node)}: no minus", f"({ast.unparse(node.operand)})"
    is_read = isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load) and node.attr in GAINS
    if is_read and ast.unparse(node) != "np.linalg.norm":
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
