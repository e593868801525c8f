"""How late ticks come: a histogram, and its percentiles."""

from collections.abc import Sequence

import numpy as np

# Twenty bins per decade from a microsecond to ten seconds: percentiles are good to 12 percent.
_BINS_PER_DECADE, _DECADES = 20, 7
_EDGES_NS = 1e3 * 10.0 ** (np.arange(_DECADES * _BINS_PER_DECADE + 1) / _BINS_PER_DECADE)

_PERCENT = (50.0, 99.0, 99.9)


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
        place = int(np.searchsorted(cumulated, cumulated[-1] * percent / 100.0))
        return min(float(_EDGES_NS[min(place, len(_EDGES_NS) - 1)]), self.most_ns)

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
