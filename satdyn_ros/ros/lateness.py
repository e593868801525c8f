"""How late ticks come: a histogram, its percentiles, and whether their pace is kept."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# Twenty bins per decade from a microsecond to ten seconds: percentiles are good to 12 percent.
_BINS_PER_DECADE, _DECADES = 20, 7
_EDGES_NS = 1e3 * 10.0 ** (np.arange(_DECADES * _BINS_PER_DECADE + 1) / _BINS_PER_DECADE)

_PERCENT = (50.0, 99.0, 99.9)


# This share of the ticks may be more than their period behind the deadline.
LATE_PART = 0.05
# A pace is judged over this time, or over some ticks; what is missing from it may be jitter.
_JUDGED_S, _JUDGED_TICKS, _LEAST_PART = 3.5, 2, 0.98


@dataclass
class Punctuality:
    """Ticks published later than one period; the largest lag; resets of the deadlines."""

    late_ticks: int = 0
    largest_lag_ns: float = 0.0
    restarts: int = 0


class Pace:
    """
    Whether the factor that is asked for is reached, judged every few seconds.

    One that is not is reported once, until it is reached again or another one is asked for.
    """

    def __init__(self, rate_hz: float):
        self._rate_hz = rate_hz
        self._factor = 0.0
        self._is_reported = False
        self._begin()

    def take(
        self, factor: float, ticks: int, counted: Punctuality, duration_s: float
    ) -> str | None:
        """
        Process what was counted since the last call; return what is to be reported of it.

        factor: what is asked for; 0: nothing is, or the ticks pause.
        """
        if factor != self._factor:
            # Both have a part in this time.
            self._factor, self._is_reported = factor, False
            self._begin()
            return None
        self._ticks += ticks
        self._late_ticks += counted.late_ticks
        self._restarts += counted.restarts
        self._duration_s += duration_s
        due = self._duration_s * self._rate_hz * factor
        if self._duration_s < _JUDGED_S or due < _JUDGED_TICKS:
            return None
        is_late = self._restarts or self._late_ticks > LATE_PART * self._ticks or self._ticks == 0
        is_missed = bool(is_late) and self._ticks < _LEAST_PART * due
        sentence = (
            f'the factor reached is {factor * self._ticks / due:.4g} and time.factor is '
            f'{factor:g}: of {self._ticks} ticks in {self._duration_s:.1f} s '
            f'{self._late_ticks} came late'
        )
        is_new, self._is_reported = is_missed and not self._is_reported, is_missed
        self._begin()
        return sentence if is_new else None

    def _begin(self):
        self._ticks = self._late_ticks = self._restarts = 0
        self._duration_s = 0.0


class Lateness:
    """The lags of ticks behind their deadlines since the start."""

    def __init__(self) -> None:
        self._counts = np.zeros(len(_EDGES_NS) + 1, np.int64)
        self.most_ns = 0.0

    def __len__(self) -> int:
        return int(np.sum(self._counts))

    def add(self, lags_ns: Sequence[float]) -> None:
        """Count ticks by their lags [ns]."""
        if lags_ns:
            self._counts += np.bincount(
                np.searchsorted(_EDGES_NS, lags_ns), minlength=len(self._counts)
            )
            self.most_ns = max(self.most_ns, *lags_ns)

    def percentile_ns(self, percent: float) -> float:
        """Return the lag [ns] that this percentage of the ticks does not exceed, rounded up."""
        cumulated = np.cumsum(self._counts)
        index = int(np.searchsorted(cumulated, cumulated[-1] * percent / 100.0))
        return min(float(_EDGES_NS[min(index, len(_EDGES_NS) - 1)]), self.most_ns)

    def histogram(self) -> dict[str, int]:
        """Return how many ticks are in each decade that has any, by its upper limit."""
        ends = range(0, len(_EDGES_NS), _BINS_PER_DECADE)
        counts = [int(np.sum(part)) for part in np.split(self._counts, [end + 1 for end in ends])]
        names = [f'up to {_text(_EDGES_NS[end])}' for end in ends] + [
            f'above {_text(_EDGES_NS[-1])}'
        ]
        return {name: count for name, count in zip(names, counts, strict=True) if count}

    def values(self) -> dict[str, str | int]:
        """Return percentiles [s] and histogram by name, as in the diagnostics."""
        return {
            **{f'lateness {p:g} % [s]': f'{self.percentile_ns(p) * 1e-9:.6f}' for p in _PERCENT},
            'largest lateness [s]': f'{self.most_ns * 1e-9:.6f}',
            **{f'ticks late {name}': count for name, count in self.histogram().items()},
        }

    def __str__(self) -> str:
        within = ', '.join(
            f'{percent:g} % within {_text(self.percentile_ns(percent))}' for percent in _PERCENT
        )
        counts = ', '.join(f'{count} {name}' for name, count in self.histogram().items())
        return f'lateness of {len(self)} ticks: {within}, at most {_text(self.most_ns)}; {counts}'


def _text(lag_ns: float) -> str:
    for unit, size_ns in (('s', 1e9), ('ms', 1e6)):
        if lag_ns >= size_ns:
            return f'{lag_ns / size_ns:.3g} {unit}'
    return f'{lag_ns / 1e3:.3g} us'
