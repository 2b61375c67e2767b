"""Transit times that the plant node reports."""

from stepped_plant import MS, make_node, sequenced, states


def test_state_reports_the_largest_transit_time() -> None:
    node = make_node(playout_ns=5 * MS)
    states(node, 10, sequenced(0, 10, made_ms=1007))  # plant time of the arrival: −5 ms
    assert states(node, 11)[-1].input_transit_ns == (-5 - 1007) * MS

    states(node, 13, sequenced(1, 13, made_ms=1008))

    state = states(node, 14, sequenced(2, 14, made_ms=1012))[-1]
    assert (state.input_transit_ns, state.input_epoch) == (-2 * MS - 1008 * MS, 1)


def test_inputs_that_waited_for_a_suspended_plant_are_no_transit() -> None:
    node = make_node()
    states(node, 1, sequenced(0, 1, made_ms=-4))
    [before] = states(node, 2, sequenced(1, 2, made_ms=-3))

    waited = [sequenced(k, 2_002, made_ms=k - 4, first=1_900) for k in range(1_900, 1_910)]
    resumed = states(node, 2_002, *waited)[-1]
    soon = states(node, 2_010, sequenced(1_950, 2_010, made_ms=1_000))[-1]
    later = states(node, 2_060, sequenced(2_059, 2_060, made_ms=2_052))[-1]

    assert before.input_transit_ns == resumed.input_transit_ns == soon.input_transit_ns == 4 * MS
    assert later.input_transit_ns == 7 * MS
    assert resumed.plant_ns == 2_001 * MS


def test_a_plant_that_waits_is_not_suspended() -> None:
    node = make_node()
    states(node, 0)
    states(node, 5_000, sequenced(0, 5_000, made_ms=4_990))

    assert states(node, 5_001, sequenced(1, 5_001, made_ms=4_989))[-1].input_transit_ns == -4_988 * MS


def test_lost_input_counts_as_arrived_with_its_repetition() -> None:
    node = make_node(playout_ns=5 * MS)
    states(node, 10, sequenced(0, 10, made_ms=10))
    states(node, 13, sequenced(3, 13, made_ms=13, previous_u=(3.0, 3.0, 2.0, 2.0)))

    assert states(node, 14)[-1].input_transit_ns == (-2 - 13 + 2) * MS


def test_break_transit_counts_for_the_first_repetition_alone() -> None:
    node = make_node()
    states(node, 10, sequenced(0, 10, made_ms=10))
    states(node, 12)
    first = states(node, 13, sequenced(3, 13, made_ms=13, previous_u=(3.0, 3.0, 2.0, 2.0)))[-1]
    second = states(node, 14, sequenced(4, 14, made_ms=14, previous_u=(4.0, 4.0, 3.0, 3.0, 2.0, 2.0)))[-1]

    assert (first.sequence_break_ns, first.input_transit_ns) == (MS, (3 - 13 + 2) * MS)
    assert second.input_transit_ns == first.input_transit_ns
