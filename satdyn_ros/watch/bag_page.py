"""A bag to watch: any part of it, at its recorded resolution."""

import asyncio
import json
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from ..report import html
from ..report.history import history
from .hub import Hub

_ROWS = 8000


class Recorded:
    """
    A bag as the source of a page: the whole of it first, then the requested windows.

    ValueError: it is not a bag written by satdyn_ros.
    """

    page = 'page/bag.html'
    files: tuple[str, ...] = (*html.PLAYER_SCRIPTS, 'page/connection.js', 'page/bag.js')

    def __init__(self, bag: str | Path):
        self._bag = bag
        self._worker = ThreadPoolExecutor(1)
        self._whole = self._window(None, None)

    async def start(self, hub: Hub) -> None:
        """Do nothing: a bag does not change."""

    async def stop(self) -> None:
        """Release the last window."""
        self._worker.shutdown(cancel_futures=True)

    async def first(self) -> Mapping[str, str]:
        """Return the whole bag."""
        return {'run': json.dumps({'type': 'run', 'run': self._whole})}

    async def asked(self, request: dict[str, Any]) -> dict[str, Any]:
        """Return the run between the times 'begin' and 'end' [s], null: the bag's own."""
        begin_s, end_s = (_time(request.get(name), name) for name in ('begin', 'end'))
        if begin_s is None and end_s is None:
            return {'success': True, 'run': self._whole}
        loop = asyncio.get_running_loop()
        run = await loop.run_in_executor(self._worker, self._window, begin_s, end_s)
        return {'success': True, 'run': run}

    def _window(self, begin_s, end_s):
        run = history(self._bag, _ROWS, begin_s, end_s)
        return html.playable(run) | {
            'title': Path(self._bag).resolve().name,
            'summary': html.summary(run),
            'note': html.band_note(run),
        }


def _time(value, name):
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > 1e12:
        raise ValueError(f'{name} must be a number of seconds')
    return float(value)
