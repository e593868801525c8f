"""The diagnostics of one node, as they come once a second."""

import math
import time
from collections import deque
from typing import Any

Parts = dict[str, dict[str, Any]]

_SILENT_S = 3.5


class Reports:
    """The newest report of a node: its parts (see listener.parts), and what they say of it."""

    def __init__(self) -> None:
        self._newest: Parts = {}
        # The two that came last: nodes of one name report in turn.
        self._last: deque[Parts] = deque(maxlen=2)
        self._heard_s = -math.inf
        self.is_paused = False

    @property
    def is_there(self) -> bool:
        """Whether the node has reported lately."""
        return time.monotonic() - self._heard_s < _SILENT_S

    @property
    def parts(self) -> Parts:
        """The parts of the newest report; none if it is old."""
        return self._newest if self.is_there else {}

    @property
    def tick(self) -> int | None:
        """The tick in the newest report."""
        return _tick(self._newest)

    @property
    def bag(self) -> str | None:
        """The bag that is being recorded."""
        return dict(self._newest.get('recorder', {}).get('values', [])).get('bag')

    def take(self, report: Parts, tick: int | None = None) -> None:
        """Take the next report; tick: of several nodes the one that is nearest to it is meant."""
        self._last.append(report)
        if tick is not None:
            report = min(self._last, key=lambda other: _ticks_away(other, tick))
        self._newest, self._heard_s = report, time.monotonic()
        self.is_paused = report.get('pacing', {}).get('text', '').startswith('paused')


def _ticks_away(report: Parts, tick: int) -> float:
    reported = _tick(report)
    return math.inf if reported is None else abs(reported - tick)


def _tick(report: Parts) -> int | None:
    reported = dict(report.get('pacing', {}).get('values', [])).get('tick')
    return None if reported is None else int(reported)
