"""Messages compared with those of a run: the same bytes, or equal to rounding."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from ..rosbag2.chunk import Contents
from .read_run import RecordedRun
from .rerun import Records

# Another machine rounds differently: its errors start at ROUNDING_RAD, and grow like the distance
# of a run whose start is perturbed by PERTURBATION_RAD.
ROUNDING_RAD = 1e-13
PERTURBATION_RAD = 1e-9


@dataclass(frozen=True)
class Difference:
    """
    A message that is not what it should be.

    Attributes
    ----------
    topic : str
        of the message
    tick : int
        of the message
    t_s : s
        from tick 0
    field : str
        in which it differs
    """

    topic: str
    tick: int
    t_s: float
    field: str

    def __str__(self) -> str:
        return f'{self.field} of {self.topic} at tick {self.tick}, {self.t_s:.9g} s'


class Comparison:
    """
    A comparison of recorded messages with the expected ones, part by part.

    Parameters
    ----------
    run : RecordedRun
        the bag

    Attributes
    ----------
    same_bytes : bool
        whether all were the same so far
    of_allowed : float
        the largest distance so far, as a fraction of what rounding may have grown to
    """

    def __init__(self, run: RecordedRun):
        self.same_bytes = True
        self.of_allowed = 0.0
        self._run = run
        self._names = {run.channel_id(name): name for name in run.names}
        # Commands have no fixed layout, and come from the bag itself: their bytes must be the
        # same.
        self._layouts = {
            i: run.layout(name)
            for i, name in self._names.items()
            if name not in run.inputs and run.names[name] in run.bag.channel_ids
        }
        self._allowed: dict[tuple[int, str], float] = {}

    def difference(
        self, recorded: np.ndarray, expected: Records, perturbed: Records | None
    ) -> Difference | None:
        """
        Return the first message that differs, None: none does.

        Parameters
        ----------
        recorded : (N,) uint8
            the bytes of the records, perhaps fewer
        expected : Records
            what they should be
        perturbed : Records or None
            those of the perturbed run; None: the bytes must be the same
        """
        if perturbed is not None:
            self._let_grow(expected, perturbed)
        if np.array_equal(recorded, expected.data[: len(recorded)]):
            return None
        self.same_bytes = False
        found, wanted = Contents(recorded), Contents(expected.data)
        count = min(len(found), len(wanted))
        differ = []
        for i in np.flatnonzero(found.heads[:count] != wanted.heads[:count])[:1].tolist():
            differ.append((i, 'position, log time or length'))
            count = i
        if len(found.data) < len(recorded):
            differ.append((count, 'length'))
        for channel_id, all_indices in wanted.indices.items():
            indices = all_indices[all_indices < count]
            if len(indices) == 0:
                continue
            rows, right = found.data_at(indices), wanted.data_at(indices)
            wrong = self._first_wrong(channel_id, rows, right, may_round=perturbed is not None)
            if wrong is not None:
                differ.append((int(indices[wrong[0]]), wrong[1]))
        if not differ:
            return None
        i, field = min(differ)
        tick = self._run.ticks.tick_of(int(wanted.log_times[i]))
        topic = self._run.names[self._names[int(wanted.channel_ids[i])]]
        return Difference(topic, tick, self._run.ticks.seconds(tick), field)

    def extra(self, recorded: np.ndarray, inputs: Collection[str] = ()) -> Difference | None:
        """
        Return the first recorded message that the run does not give, or None.

        Parameters
        ----------
        recorded : (N,) uint8
            the bytes of whole records
        inputs : collection of str
            topics by their names in the scenario, whose messages may be among them
        """
        found = Contents(recorded)
        extra = {i: n[0] for i, n in found.indices.items() if self._names.get(i) not in inputs}
        if not extra:
            return None
        self.same_bytes = False
        channel_id = min(extra, key=extra.__getitem__)
        tick = self._run.ticks.tick_of(int(found.log_times[extra[channel_id]]))
        topic = self._run.names.get(self._names.get(channel_id, ''), 'another topic')
        return Difference(topic, tick, self._run.ticks.seconds(tick), 'an extra message')

    def _first_wrong(self, channel_id, rows, right, may_round):
        """Return the first of rows (n, length) that is wrong, and the field in it."""
        if channel_id not in self._layouts:
            pairs = zip(rows, right, strict=True)
            found = [row for row, (a, b) in enumerate(pairs) if bytes(a) != bytes(b)]
            return (found[0], 'the command') if found else None
        layout = self._layouts[channel_id]
        wrong = rows != right
        for field in _numbers(layout) if may_round else ():
            distance = _distance(rows, right, layout, field)
            allowed = self._allowed[channel_id, field] + self._step(channel_id)
            dtype, offset = _fields(layout)[field][:2]
            wrong[distance <= allowed, offset : offset + dtype.itemsize] = False
            if allowed > 0.0:
                self.of_allowed = max(self.of_allowed, float(np.max(distance)) / allowed)
        for row in np.flatnonzero(np.any(wrong, axis=1))[:1].tolist():
            return row, _field_at(layout, np.argmax(wrong[row]))
        return None

    def _step(self, channel_id):
        """Return how far a sample moves if rounding puts it on the next step, in all axes."""
        sensor = self._run.scenario.sensors.get(self._names[channel_id])
        return np.sqrt(3.0) * sensor.resolution if sensor else 0.0

    def _let_grow(self, expected, perturbed):
        """Update how far the perturbed run has moved from the expected one."""
        if expected.starts_anew:
            self._allowed.clear()
        contents, moved = Contents(expected.data), Contents(perturbed.data)
        for channel_id in contents.indices.keys() & self._layouts.keys():
            layout = self._layouts[channel_id]
            rows, turned = (c.data_at(c.indices[channel_id]) for c in (contents, moved))
            for field in _numbers(layout):
                size = float(np.max(_distance(rows, np.zeros_like(rows), layout, field)))
                if (self._names[channel_id], field[:8]) == ('rotor', 'position'):
                    # The integral of a difference of rates is as uncertain as the attitude,
                    # whatever is left of it.
                    size = max(size, 1.0)
                grown = float(np.max(_distance(rows, turned, layout, field))) / PERTURBATION_RAD
                allowed = ROUNDING_RAD * (size + grown)
                before = self._allowed.get((channel_id, field), 0.0)
                self._allowed[channel_id, field] = max(before, allowed)


def _fields(layout: np.dtype) -> Mapping[str, tuple]:
    return layout.fields or {}


def _numbers(layout):
    return [name for name in layout.names if layout[name].base.kind == 'f']


def _distance(a, b, layout, field):
    """Return the distance of a field's values in the rows a and b (n, length), shape (n,)."""
    difference = a.view(layout)[field][:, 0] - b.view(layout)[field][:, 0]
    return np.linalg.norm(difference.reshape(len(a), -1), axis=1)


def _field_at(layout, position):
    """Return the field at a byte of a message."""
    for name in layout.names:
        dtype, offset = _fields(layout)[name][:2]
        if offset <= position < offset + dtype.itemsize:
            return name
    return 'a constant'
