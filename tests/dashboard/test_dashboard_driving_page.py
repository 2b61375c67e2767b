"""The messages that wait for a page that reads slowly are bounded: the newest ones, and one clock."""

import asyncio
import json

from passafe_dashboard.live.drive_requests import PENDING, DrivingPage


def test_a_stalled_page_keeps_the_newest() -> None:
    async def stalled() -> list[str]:
        page = DrivingPage(1)
        for number in range(1_000):
            page.show_clock(json.dumps({"clock": number}))
            page.send({"number": number})
        return await page.next_texts()

    texts = [json.loads(text) for text in asyncio.run(stalled())]
    assert texts[:-1] == [{"number": number} for number in range(1_000 - PENDING, 1_000)]
    assert texts[-1] == {"clock": 999}


def test_nothing_is_sent_twice() -> None:
    async def scenario() -> bool:
        page = DrivingPage(1)
        page.send({})
        await page.next_texts()
        waiting = asyncio.ensure_future(page.next_texts())
        await asyncio.sleep(0)
        is_waiting = not waiting.done()
        waiting.cancel()
        return is_waiting

    assert asyncio.run(scenario())
