"""
Learn a law of magnetorquers that damps a tumble, by the cross-entropy method in plain NumPy.

    python examples/learn_to_detumble.py -o detumbler.png
The dipole is linear in the nine products of a rate and a field; the 27 weights are drawn, flown
and drawn anew about the best (Rubinstein and Kroese, The cross-entropy method, 2004).  What is
found comes near omega x B, the law of textbooks, of which nothing was said.
"""

import argparse
import time
from dataclasses import replace

import numpy as np

from satdyn_ros.gym import SatelliteVectorEnv
from satdyn_ros.gym.tasks import detumble

CANDIDATES, STARTS, BEST = 128, 8, 16
SATELLITES = CANDIDATES * STARTS


def dipoles(weights, seen):
    """Return the actions (M, 3) of weights (M, 3, 9) for observations (M, 6)."""
    rates, fields = seen[:, :3], seen[:, 3:]
    products = (rates[:, :, None] * fields[:, None, :]).reshape(-1, 9)
    return np.einsum('mij,mj->mi', weights, products)


def flown(envs, weights, seeds):
    """Return of weights (M, 3, 9) from starts (M,) the rewards and the last rates [deg/s] (M,)."""
    seen, _ = envs.reset(seed=seeds)
    total = np.zeros(envs.num_envs)
    for _ in range(envs.task.ticks // envs.task.ticks_of_an_action):
        seen, rewards, *_ = envs.step(dipoles(weights, seen))
        total += rewards
    rates = np.linalg.norm(seen[:, :3], axis=-1) / envs.task.observation['omega_bi_b']
    return total, np.degrees(rates)


def main():
    """Learn, and say how fast the bodies turn at the end of an episode."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--generations', type=int, default=20)
    parser.add_argument('-o', dest='out', help='draw the curve into this file')
    given = parser.parse_args()

    envs = SatelliteVectorEnv(replace(detumble(), duration_s=1500.0), SATELLITES)
    rng, begun = np.random.default_rng(1), time.monotonic()
    mean, deviation = np.zeros((3, 9)), np.full((3, 9), 0.5)
    curve = []
    for generation in range(given.generations):
        drawn = mean + deviation * rng.normal(size=(CANDIDATES, 3, 9))
        # All candidates begin at the same starts.
        each, starts = np.repeat(drawn, STARTS, axis=0), [*range(STARTS)] * CANDIDATES
        rewards, rates = (x.reshape(-1, STARTS).mean(axis=1) for x in flown(envs, each, starts))
        best = np.argsort(rewards)[-BEST:]
        mean, deviation = drawn[best].mean(axis=0), drawn[best].std(axis=0) + 0.02
        curve.append((np.median(rewards), rates[best].mean()))
        print(
            f'generation {generation:2}: median reward {curve[-1][0]:8.1f}, '
            f'the best end at {curve[-1][1]:5.2f} deg/s'
        )
    _, rates = flown(envs, np.repeat(mean[None], SATELLITES, axis=0), [*range(1000, 2024)])
    print(f'{SATELLITES} others end at {np.median(rates):.2f} deg/s or less, half of them')
    law = mean / np.linalg.norm(mean)
    # Of the products of rate i and field j.
    cross = np.zeros((3, 3, 3))
    for i, j, k in (0, 1, 2), (1, 2, 0), (2, 0, 1):
        cross[k, i, j], cross[k, j, i] = 1.0, -1.0
    alike = np.sum(law * cross.reshape(3, 9)) / np.sqrt(6.0)
    print(f'the law is {alike:.2f} like omega x B, learned in {time.monotonic() - begun:.0f} s')
    if given.out:
        draw(curve, given.out)


def draw(curve, path):
    """Draw the median reward and the rate at the end, by generation."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, sharex=True, figsize=(7, 5), layout='constrained')
    for axis, values, label in zip(
        axes, zip(*curve, strict=True), ('median reward', 'rate at the end [deg/s]'), strict=True
    ):
        axis.plot(values)
        axis.set_ylabel(label)
        axis.grid(alpha=0.3)
    axes[1].set_ylim(bottom=0.0)
    axes[1].set_xlabel('generation')
    figure.savefig(path, dpi=100)


if __name__ == '__main__':
    main()
