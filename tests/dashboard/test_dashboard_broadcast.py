import asyncio
import json
from typing import Any

from closed_form import MS, ClosedFormRun, paper_scenario
from passafe_dashboard.live.broadcast import Broadcast
from passafe_dashboard.live.feed import Feed
from passafe_services.loop.pace import Pace


class VirtualRun:
    """A closed-form run whose clock goes on by ``step_ns`` with every frame."""

    def __init__(self, step_ms: int = 33, **of_feed: Any) -> None:  # noqa: ANN401 - of Feed
        self.feed = Feed(paper_scenario(), **of_feed)
        self.now_ns = 0
        self.reads = 0
        self._step_ns = step_ms * MS
        self._run = ClosedFormRun()
        self.broadcast = Broadcast(self.feed, read=self._read, clock=lambda: self.now_ns)

    def _read(self, now_ns: int, pace: Pace) -> None:
        assert pace is self.broadcast.pace
        for message in self._run.until(now_ns):
            self.feed.push(*message)
        self.reads += 1

    def step(self) -> None:
        """Let one frame pass."""
        self.now_ns += self._step_ns
        self.broadcast.step()


def read(text: str) -> dict[str, Any]:
    frame: dict[str, Any] = json.loads(text)
    return frame


def test_every_client_gets_every_row() -> None:
    async def scenario() -> list[list[int]]:
        run = VirtualRun()
        clients = [run.broadcast.frames() for _ in range(3)]
        seen: list[list[int]] = [[], [], []]
        for _ in range(20):
            waiting = [asyncio.ensure_future(anext(client)) for client in clients]
            await asyncio.sleep(0)
            assert run.broadcast.clients == 3
            run.step()
            for number, future in enumerate(waiting):
                seen[number].append(len(read(await future)["tables"]["ticks"]))
        for client in clients:
            await client.aclose()
        assert run.broadcast.clients == 0
        return seen

    seen = asyncio.run(scenario())
    assert seen[0] == seen[1] == seen[2]
    assert sum(seen[0]) == 19


def test_slow_client_delays_nobody_and_loses_the_oldest_rows() -> None:
    async def scenario() -> tuple[VirtualRun, list[int], dict[str, Any]]:
        run = VirtualRun(history_s=1.0)
        quick, slow = run.broadcast.frames(), run.broadcast.frames()
        held_up = asyncio.ensure_future(anext(slow))
        quick_rows = []
        for _ in range(200):
            waiting = asyncio.ensure_future(anext(quick))
            await asyncio.sleep(0)
            run.step()
            quick_rows.append(len(read(await waiting)["tables"]["ticks"]))
        await held_up  # the slow one sends its first frame only now
        late = asyncio.ensure_future(anext(slow))
        await asyncio.sleep(0)
        run.step()
        frame = read(await late)
        await quick.aclose()
        await slow.aclose()
        return run, quick_rows, frame

    run, quick_rows, frame = asyncio.run(scenario())
    assert run.reads == 201
    assert sum(quick_rows) == 197
    assert len(frame["tables"]["ticks"]) == 30
    assert frame["lost"] == 198 - 30
    assert frame["now"]["worst"]["barriers"][0]["measured"]["value"] < 0.4401  # of the rows that it lost, too


def test_page_state_is_made_once_a_frame_and_only_for_clients() -> None:
    async def scenario() -> int:
        run = VirtualRun()
        run.step()
        made_without_clients = run.broadcast._now_text is not None
        clients = [run.broadcast.frames() for _ in range(4)]
        waiting = [asyncio.ensure_future(anext(client)) for client in clients]
        await asyncio.sleep(0)
        run.step()
        texts = {(await future).partition('"now":')[2] for future in waiting}
        for client in clients:
            await client.aclose()
        assert not made_without_clients
        return len(texts)

    assert asyncio.run(scenario()) == 1


def test_end_of_the_run_is_the_last_frame() -> None:
    async def scenario() -> list[str]:
        run = VirtualRun()
        states = []

        async def follow() -> None:
            async for text in run.broadcast.frames():
                states.append(read(text)["now"]["liveness"]["state"])  # noqa: PERF401 - a generator's items

        following = asyncio.create_task(follow())
        await asyncio.sleep(0)
        run.step()
        await asyncio.sleep(0)
        run.broadcast.finish("The run has ended.")
        await asyncio.wait_for(following, 5)
        assert run.broadcast.clients == 0
        return states

    assert asyncio.run(scenario()) == ["live", "ended"]


def test_late_client_receives_the_end_of_the_run() -> None:
    async def scenario() -> list[dict[str, Any]]:
        run = VirtualRun()
        for _ in range(10):
            run.step()
        run.broadcast.finish("The run has ended.")
        return [read(text) async for text in run.broadcast.frames()]

    frames = asyncio.run(scenario())
    assert len(frames) == 1
    assert frames[0]["now"]["liveness"]["text"] == "The run has ended."
    assert len(frames[0]["tables"]["ticks"]) == 9


def test_running_keeps_the_rate_against_a_real_clock() -> None:
    async def scenario() -> Broadcast:
        loop = asyncio.get_running_loop()
        arrived = asyncio.Event()

        def read_bus(now_ns: int, pace: Pace) -> None:
            del now_ns
            if pace.steps == 5:
                arrived.set()

        broadcast = Broadcast(Feed(), read=read_bus, clock=lambda: round(loop.time() * 1e9), frame_hz=200.0)
        running = asyncio.create_task(broadcast.run())
        begun = loop.time()
        await asyncio.wait_for(arrived.wait(), 30)
        assert loop.time() - begun >= 5 / 200 - 0.001
        running.cancel()
        return broadcast

    assert asyncio.run(scenario()).pace.steps >= 5
