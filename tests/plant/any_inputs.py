"""Any inputs to a plant node, over steps at which some of them arrive."""

from typing import Final, TypeAlias

from hypothesis import strategies as st
from passafe_protocol.messages import UNSEQUENCED, PlantInput
from stepped_plant import BOUND, MS

Steps: TypeAlias = list[tuple[int, list[tuple[int, int, PlantInput]]]]
"""For each step the periods that are skipped before it, and epoch, time of making in ns and body of what arrives."""

_NUMBER: Final = st.one_of(st.floats(-120, 120), st.sampled_from([float("nan"), float("inf"), BOUND, -BOUND]))
_PAIR: Final = st.tuples(st.floats(-BOUND, BOUND), st.floats(-BOUND, BOUND))
_TIME_NS: Final = st.one_of(
    st.integers(-3, 25).map(lambda k: k * MS), st.sampled_from([UNSEQUENCED, MS + 1, -(2**63), 2**63 - 1])
)
_PARTS: Final = {
    "tick": st.one_of(st.integers(0, 40), st.just(2**64 - 1)),
    "u": st.one_of(_PAIR, st.lists(_NUMBER, max_size=5).map(tuple)),
    "effective_plant_ns": _TIME_NS,
    "hold_ns": st.sampled_from([0, MS, 2**64 - 1]),
}
_OF_A_SEQUENCE: Final = {
    "input_sequence_start_ns": _TIME_NS.filter(lambda ns: ns >= UNSEQUENCED),
    "known_break_ns": _TIME_NS.filter(lambda ns: ns >= UNSEQUENCED),
    "previous_u": st.one_of(
        st.lists(_NUMBER, max_size=5).map(tuple),
        st.lists(_PAIR, max_size=6).map(lambda pairs: sum(pairs, ())),
    ),
}


def any_steps(*, sequenced: bool) -> st.SearchStrategy[Steps]:
    """Return a strategy of steps.

    Args:
        sequenced: Whether inputs may belong to a sequence.
    """
    body = st.builds(PlantInput, **(_PARTS | _OF_A_SEQUENCE if sequenced else _PARTS))
    arriving = st.lists(st.tuples(st.integers(1, 3), _TIME_NS, body), max_size=4)
    return st.lists(st.tuples(st.integers(0, 3), arriving), max_size=25)
