"""Waits for the first of several things."""

import asyncio
from collections.abc import Coroutine, Iterable
from typing import Any


async def first_of(
    waits: Iterable[Coroutine[Any, Any, Any]], ends: Iterable[asyncio.Future[int]], timeout_s: float | None
) -> None:
    """Wait until one of the awaitables is done, at most ``timeout_s``."""
    tasks = [asyncio.ensure_future(wait) for wait in waits]
    pending: list[asyncio.Future[Any]] = [*tasks, *ends]
    try:
        await asyncio.wait(pending, timeout=timeout_s, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
