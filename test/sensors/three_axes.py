"""What tests of sensors of three axes, such as a gyro, ask of their samples."""

import allantools
import numpy as np


def measured(sensor, states, blocks=(None,)):
    """Return the samples (M, 3) of consecutive states, measured in blocks that end at `blocks`."""
    memory, values, begin = sensor.memory, [], 0
    for end in [*(len(states) if end is None else end for end in blocks)]:
        found, memory = sensor.measure(range(begin, end), states.rows(slice(begin, end)), memory)
        values.append(found.values)
        begin = end
    return np.concatenate(values)


def within_three_sigma(samples, interval_s, deviation, power):
    """
    Assert that the theory lies in the confidence of the Allan deviations of samples (M, 3).

    power: the exponent of the noise's spectrum in frequency, by which the freedom is counted.
    """
    for axis in range(3):
        taus, found, _, counts = allantools.oadev(
            samples[:, axis], rate=1.0 / interval_s, data_type='freq', taus=[1.0, 10.0, 100.0]
        )
        for tau, sigma, n in zip(taus, found, counts, strict=True):
            m = round(tau / interval_s)
            freedom = allantools.edf_simple(n + 2 * m, m, power)
            low, high = allantools.confidence_interval(sigma, freedom, ci=0.9973)
            assert low < deviation(tau) < high, (axis, tau, sigma, deviation(tau))
