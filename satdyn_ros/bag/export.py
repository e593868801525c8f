"""The states in a bag as a table: CSV, NPZ or Parquet, a row a tick."""

import csv
from pathlib import Path

import numpy as np

from ..rosbag2.reader import Messages, TopicBlock
from .recorded_run import RecordedRun

_Q_IB = ['q_ib_x', 'q_ib_y', 'q_ib_z', 'q_ib_w']
_OMEGA = ['omega_bi_b_x_rad_s', 'omega_bi_b_y_rad_s', 'omega_bi_b_z_rad_s']

# By topic its fields and their columns; what two topics say is taken from the first.
_COLUMNS = {
    'attitude': {'quaternion': _Q_IB},
    'angular_velocity': {'velocity.angular': _OMEGA},
    'imu': {'orientation': _Q_IB, 'angular_velocity': _OMEGA},
    'odometry': {
        'pose.pose.orientation': _Q_IB,
        'twist.twist.angular': _OMEGA,
        'pose.pose.position': ['r_i_x_m', 'r_i_y_m', 'r_i_z_m'],
        'twist.twist.linear': ['v_b_x_m_s', 'v_b_y_m_s', 'v_b_z_m_s'],
    },
    'attitude_lvlh': {'quaternion': ['q_lb_x', 'q_lb_y', 'q_lb_z', 'q_lb_w']},
    'gravity_gradient': {
        'wrench.torque': [
            'gravity_gradient_b_x_n_m',
            'gravity_gradient_b_y_n_m',
            'gravity_gradient_b_z_n_m',
        ]
    },
    'rotor': {
        'position[0]': ['rotor_angle_rad'],
        'velocity[0]': ['rotor_speed_rad_s'],
        'effort[0]': ['rotor_torque_n_m'],
    },
}
_CSV_ROWS = 65536


def table(path: str | Path) -> dict[str, np.ndarray]:
    """
    Return the states in a bag: columns (N,) by name, a row a tick.

    tick, t_s (from tick 0) and stamp_ns come first; the others are those that the recorded topics
    say, nan at a tick where they were not published.  ValueError: path is no bag of ours.
    """
    run = RecordedRun(path)
    found = _messages(run)
    log_times_ns = [np.empty(0, np.uint64), *(m.log_times_ns for m in found.values())]
    stamps_ns = np.unique(np.concatenate(log_times_ns)).astype(np.int64)
    rate, since_ns = run.scenario.rate, stamps_ns - run.scenario.epoch_ns
    # A stamp is within half a nanosecond of its tick's time, which doubles tell apart for ages.
    ticks = np.rint(since_ns * (float(rate) * 1e-9)).astype(np.int64)
    columns = {
        'tick': ticks,
        't_s': ticks * rate.denominator / rate.numerator,
        'stamp_ns': stamps_ns,
    }
    for topic, messages in found.items():
        rows = run.rows(topic, messages)
        places = np.searchsorted(stamps_ns, messages.log_times_ns.astype(np.int64))
        for field, names in _COLUMNS[topic].items():
            if field not in (rows.dtype.names or ()):
                continue
            values = rows[field].reshape(len(rows), -1)
            for name, value in zip(names, values.T, strict=True):
                column = columns.setdefault(name, np.full(len(stamps_ns), np.nan))
                column[places] = np.where(np.isnan(column[places]), value, column[places])
    return columns


def export(path: str | Path, output: str | Path) -> int:
    """
    Write the states in a bag as a table and return its number of rows.

    output: what its name ends with says the format: .csv, .npz or .parquet.  ValueError: it is
    another, what it takes is not installed, or path is no bag of ours.
    """
    output = Path(output)
    write = _WRITERS.get(output.suffix)
    if write is None:
        raise ValueError(f'{output} ends with neither {", ".join(_WRITERS)}')
    columns = table(path)
    write(output, columns)
    return len(columns['tick'])


def _messages(run: RecordedRun) -> dict[str, Messages]:
    """Return the messages of the topics that have columns, by their names in the scenario."""
    parts: dict[str, list[Messages]] = {name: [] for name in _COLUMNS}
    for item in run.bag.items():
        if isinstance(item, TopicBlock):
            by_topic = item.by_topic()
            for name, collected in parts.items():
                if run.names[name] in by_topic:
                    collected.append(by_topic[run.names[name]])
    return {name: Messages.joined(collected) for name, collected in parts.items() if collected}


def _write_csv(output, columns):
    with open(output, 'w', newline='', encoding='utf-8') as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        for first in range(0, len(columns['tick']), _CSV_ROWS):
            part = (column[first : first + _CSV_ROWS].tolist() for column in columns.values())
            writer.writerows(zip(*part, strict=True))


def _write_npz(output, columns):
    np.savez(output, **columns)


def _write_parquet(output, columns):
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise ValueError(
            'a .parquet file takes pyarrow, which is not installed; .csv and .npz do not'
        ) from error
    pyarrow.parquet.write_table(pyarrow.table(columns), output)


_WRITERS = {'.csv': _write_csv, '.npz': _write_npz, '.parquet': _write_parquet}
