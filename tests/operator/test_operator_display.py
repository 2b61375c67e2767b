"""The display that the operator node feeds."""

from passafe_protocol.messages import (
    FilterStatus,
)
from passafe_protocol.topics import LEASE, STATE, TICK
from passafe_services.operator.keyboard.display import OperatorView
from passafe_services.operator.node import DISPLAY_PERIOD_NS, DISPLAY_STALE_NS, OperatorNode
from stepped_operator import EPOCH, MS, TimeTeller, lease, state, stopped, tick


def test_a_node_reads_filter_ticks_only_for_somebody_to_see() -> None:
    assert OperatorNode(TimeTeller(), epoch=EPOCH).subscribes == (STATE, LEASE)
    assert OperatorNode(TimeTeller(), epoch=EPOCH, show=lambda _: None).subscribes == (STATE, LEASE, TICK)


def test_the_display_is_fed_ten_times_a_second_at_most() -> None:
    views: list[OperatorView] = []
    node = OperatorNode(TimeTeller(), epoch=EPOCH, show=views.append)
    for step in range(1001):
        node.step(step * MS, ())
    assert len(views) == 1000 * MS // DISPLAY_PERIOD_NS + 1


def test_display_shows_position_and_nearest_limit() -> None:
    views: list[OperatorView] = []
    node = OperatorNode(TimeTeller(), epoch=EPOCH, show=views.append)
    node.step(10 * MS, [state(0, 10 * MS), tick(10 * MS, {"wall": 0.5, "disk": -0.25, "box": 3.0})])
    assert views == [
        OperatorView(
            u_h=(0.0,),
            enabled=True,
            holder="",
            stop_source="",
            position=(1.0,),
            status=FilterStatus.MODIFIED,
            nearest=("disk", -0.25),
        )
    ]


def test_the_display_forgets_what_is_old() -> None:
    views: list[OperatorView] = []
    node = OperatorNode(TimeTeller(), epoch=EPOCH, show=views.append)
    node.step(0, [state(0, 0), tick(0, {"disk": 1.0})])
    node.step(DISPLAY_STALE_NS, ())
    node.step(DISPLAY_STALE_NS + DISPLAY_PERIOD_NS, ())
    assert [view.position for view in views] == [(1.0,), (1.0,), None]
    assert [view.status is None for view in views] == [False, False, True]
    assert views[2].nearest is None


def test_a_tick_without_barriers_shows_its_status() -> None:
    views: list[OperatorView] = []
    OperatorNode(TimeTeller(), epoch=EPOCH, show=views.append).step(0, [tick(0, {})])
    assert views[0].status is FilterStatus.MODIFIED
    assert views[0].nearest is None


def test_display_shows_who_holds_the_lease_and_who_stopped() -> None:
    views: list[OperatorView] = []
    node = OperatorNode(TimeTeller(), epoch=EPOCH, show=views.append)
    node.step(0, [lease(7)])
    node.step(DISPLAY_PERIOD_NS, [stopped(0, stop=3)])

    assert [(view.holder, view.stop_source) for view in views] == [
        ("session 7 (other)", ""),
        ("session 7 (other)", "console"),
    ]
