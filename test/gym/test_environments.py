"""Environments of Gymnasium: its own checks, and the batch beside single ones, bit by bit."""

import hashlib
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip('gymnasium')

import gymnasium
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from satdyn_ros.bag.verify import verify
from satdyn_ros.gym import SatelliteEnv, SatelliteVectorEnv, Task
from satdyn_ros.gym.tasks import TASKS, task_of
from satdyn_ros.kernel import rotation
from satdyn_ros.run.scenario import Scenario

# More than a group of lanes.
COUNT = 9
SENSING = Scenario(
    {
        'body.inertia': [0.058, 0.062, 0.025],
        'magnetorquer.max_dipole': [0.2, 0.2, 0.2],
        'orbit.type': 'kepler',
        'environment.magnetic_field': 'igrf',
        'sensors.names': ['magnetometer', 'star_tracker'],
        'sensors.magnetometer.noise': 1e-7,
        'sensors.magnetometer.divisor': 3,
        'sensors.star_tracker.latency': 2,
        'publish.rate': 1.0,
        'time.epoch': '2026-01-01T00:00:00Z',
    }
)


def sensing():
    """Return a task of what sensors measure, of bodies that differ, some of which end early."""
    return Task(
        SENSING,
        observation={'measured.magnetometer': 1e4, 'measured.star_tracker': 1.0},
        action={'dipole_b': [0.2, 0.2, 0.2], 'torque_b': [1e-3, 1e-3, 1e-3]},
        reward=lambda sample, action: -np.sum(sample.omega_bi_b**2, axis=-1),
        duration_s=14.0,
        interval_s=2.0,
        vary={
            'initial.attitude': 'sphere',
            'initial.angular_velocity': {'normal': [[0.0] * 3, [0.05] * 3]},
            'body.inertia.x': {'uniform': [0.05, 0.06]},
        },
        ends=lambda sample: np.abs(sample.omega_bi_b[..., 0]) > 0.1,
    )


def short(name):
    """Return a task whose episodes have seven actions."""
    if name == 'sensing':
        return sensing()
    task = task_of(name)
    return replace(task, duration_s=round(7 * task.interval_s, 3))


@pytest.mark.parametrize('name', TASKS)
def test_gymnasium_finds_nothing_wrong(name):
    """By its own checks, of the environment that its register makes."""
    check_env(gymnasium.make(f'satdyn_ros.gym:satdyn/{name}-v0').unwrapped)


@pytest.mark.parametrize('mode', AutoresetMode)
@pytest.mark.parametrize('name', [*TASKS, 'sensing'])
def test_the_batch_is_the_single_ones(name, mode):
    """Observations, ends and infos, over three episodes of each: as by SyncVectorEnv."""
    task = short(name)
    alone = SyncVectorEnv([lambda: SatelliteEnv(task)] * COUNT, autoreset_mode=mode)
    batch = SatelliteVectorEnv(task, COUNT, mode)
    rng = np.random.default_rng(0)
    mine, _ = batch.reset(seed=5)
    others, _ = alone.reset(seed=5)
    hashes = [(digest(mine), digest(others))]
    episodes = np.zeros(COUNT, int)
    while episodes.min() < 3:
        actions = rng.uniform(-1.2, 1.2, batch.action_space.shape).astype(np.float32)
        mine, reward, over, out_of_time, info = batch.step(actions)
        others, reward_alone, *ends_alone, info_alone = alone.step(actions)
        hashes.append((digest(mine), digest(others)))
        np.testing.assert_allclose(reward, reward_alone, rtol=1e-12)
        np.testing.assert_array_equal([over, out_of_time], ends_alone)
        assert info.keys() == info_alone.keys()
        for one, other in zip(
            info.get('final_obs', ()), info_alone.get('final_obs', ()), strict=True
        ):
            np.testing.assert_array_equal(one, other)
        ended = over | out_of_time
        episodes += ended
        if mode is AutoresetMode.DISABLED and ended.any():
            mine, _ = batch.reset(options={'reset_mask': ended})
            others, _ = alone.reset(options={'reset_mask': ended.copy()})
            hashes.append((digest(mine), digest(others)))
    assert [one for one, _ in hashes] == [other for _, other in hashes]
    if name == 'sensing':
        assert len(set(episodes.tolist())) > 1  # Some ended before their time.


def digest(numbers):
    return hashlib.sha256(np.ascontiguousarray(numbers).tobytes()).hexdigest()


def test_a_batch_is_made_by_its_name():
    """By gymnasium.make_vec, with the mode asked for."""
    envs = gymnasium.make_vec(
        'satdyn_ros.gym:satdyn/Detumble-v0', num_envs=3, autoreset_mode='SameStep'
    )
    assert isinstance(envs.unwrapped, SatelliteVectorEnv)
    assert envs.metadata['autoreset_mode'] is AutoresetMode.SAME_STEP
    assert envs.reset(seed=1)[0].shape == (3, 6)


def test_an_episode_is_a_bag_that_verifies(tmp_path):
    """Each in a directory of its own, the last when the environment is closed."""
    env = SatelliteEnv(short('Point'), record=tmp_path / 'bags')
    for seed in (1, 2):
        env.reset(seed=seed)
        for _ in range(7):
            *_, out_of_time, _ = env.step(env.action_space.sample())
        assert out_of_time
    env.close()
    for episode in ('episode_0000', 'episode_0001'):
        assert verify(tmp_path / 'bags' / episode).is_true


def test_a_motion_that_halts_ends_its_episode():
    """The info says why; the others go on, and it begins again."""
    task = replace(
        short('Point'), action={'torque_b': [1e300, 1e300, 1e300]}, observation={'omega_bi_b': 1.0}
    )
    envs = SatelliteVectorEnv(task, 3)
    envs.reset(seed=1)
    actions = np.zeros((3, 3), np.float32)
    actions[1] = 1.0
    *_, over, _, info = envs.step(actions)
    assert over.tolist() == [False, True, False]
    assert 'halt' in info['halted'][1]
    *_, over, _, _ = envs.step(np.zeros((3, 3), np.float32))
    assert not over.any()


def test_an_action_that_is_no_number_is_refused():
    """By the actuator and the run that it is of; the environments are as they were."""
    envs = SatelliteVectorEnv('Point', 3)
    envs.reset(seed=1)
    actions = np.zeros((3, 3), np.float32)
    actions[2, 1] = np.nan
    with pytest.raises(ValueError, match='rotor_torque of rw_y of run 2 is nan'):
        envs.step(actions)
    env = SatelliteEnv('Point')
    env.reset(seed=1)
    with pytest.raises(ValueError, match='torque on the rotor rw_y is nan'):
        env.step(actions[2])


REFUSED = {
    'a word that is none': (
        {'action': {'thrust': 1.0}},
        'action has thrust; it may have torque_b',
    ),
    'a sensor that is not there': ({'observation': {'measured.gyro': 1.0}}, 'sensors.names has'),
    'nothing of a sample': (
        {'observation': {'rate': 1.0}},
        'a sample holds t_s, q_ib, omega_bi_b',
    ),
    'nothing at all': ({'observation': {}}, 'observation is empty; a sample holds t_s'),
    'an interval between ticks': ({'interval_s': 0.5}, 'interval_s is 0.5'),
    'no interval': ({'interval_s': np.nan}, 'interval_s is nan; it must be a multiple'),
    'a key that is none': ({'vary': {'body.mass': 'sphere'}}, 'body.mass'),
}


@pytest.mark.parametrize(('changes', 'why'), REFUSED.values(), ids=REFUSED)
def test_a_task_that_cannot_be_is_refused(changes, why):
    """In one sentence."""
    with pytest.raises(ValueError, match=why):
        replace(sensing(), **changes)


@pytest.mark.parametrize(
    ('name', 'why'),
    [
        ('torques_b', r'observation has torques_b; of torques_b there is torques_b\.gravity_'),
        ('torques_b.drag', r'observation has torques_b\.drag; of torques_b there is torques_b\.g'),
        ('q_ib.w', r'observation has q_ib\.w; q_ib has no parts with names'),
    ],
)
def test_a_part_that_a_sample_does_not_have_is_refused(name, why):
    """In one sentence, when the environment is made."""
    with pytest.raises(ValueError, match=why):
        SatelliteEnv(replace(sensing(), observation={name: 1.0}))


@pytest.mark.parametrize('shape', [(2,), (4,), (1, 3), ()])
def test_an_action_of_another_shape_is_refused(shape):
    """By one and by many, of which one row does not stand for all."""
    env, envs = SatelliteEnv('Point'), SatelliteVectorEnv('Point', 3)
    env.reset(seed=1)
    envs.reset(seed=1)
    with pytest.raises(ValueError, match=r'the action has the shape .*; it must be \(3,\)'):
        env.step(np.zeros(shape))
    for wrong in ((3,), (3, *shape)):
        with pytest.raises(ValueError, match=r'the action has the shape .*; it must be \(3, 3'):
            envs.step(np.zeros(wrong))


def test_the_reward_is_of_the_action_that_acts():
    """Beyond -1 and 1 it is cut: a policy is not charged for what is not done."""
    env, envs = SatelliteEnv('Point'), SatelliteVectorEnv('Point', 2)
    rewards = []
    for action in (1.0, 40.0):
        env.reset(seed=1)
        envs.reset(seed=1)
        _, one, *_ = env.step(np.full(3, action))
        _, many, *_ = envs.step(np.full((2, 3), action))
        rewards.append((one, *many))
    assert rewards[0] == rewards[1]


def test_what_is_given_in_place_of_another_key_can_be_drawn():
    """As in a sweep: an altitude, and three angles at once."""
    vary = {
        'orbit.altitude': {'uniform': [4e5, 5e5]},
        'initial.roll_pitch_yaw': {'uniform': [[0.1, 0.2, 0.3], [0.1, 0.2, 0.3]]},
    }
    scenario = replace(task_of('Point'), vary=vary).draw(np.random.default_rng(1))
    assert 4e5 <= scenario['orbit.semi_major_axis'] - 6378137.0 <= 5e5
    angles = rotation.roll_pitch_yaw(scenario['initial.attitude'])
    np.testing.assert_allclose(angles, [0.1, 0.2, 0.3], atol=1e-15)


def test_what_cannot_be_a_batch_is_refused():
    """No satellites, and a seed that Gymnasium itself does not take."""
    with pytest.raises(ValueError, match='num_envs is 0; it must be an integer of at least 1'):
        SatelliteVectorEnv('Point', 0)
    with pytest.raises(gymnasium.error.Error, match='Seed must be a python integer'):
        SatelliteVectorEnv('Point', 2).reset(seed=np.int64(3))


def test_before_its_first_reset_it_says_so():
    """One and many."""
    with pytest.raises(gymnasium.error.ResetNeeded):
        SatelliteEnv('Point').step(np.zeros(3))
    with pytest.raises(ValueError, match='reset the environments'):
        SatelliteVectorEnv('Point', 2).step(np.zeros((2, 3)))
    with pytest.raises(ValueError, match='must be one of Detumble, Point, Slew'):
        SatelliteEnv('Fly')
