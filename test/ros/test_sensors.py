"""The sensors of a live node: their bytes on the wire, and the bag that proves them."""

from satdyn_ros.bag.verify import verify
from satdyn_ros.base.sparse import SparseMessages
from satdyn_ros.messages.packers import packer
from satdyn_ros.run.simulation import Simulation

NAMES = ['gyro', 'star_tracker', 'st2', 'magnetometer', 'sun_sensor', 'coarse_sun_sensor']
VALUES = {
    'publish.topics': ['attitude'],
    'environment.magnetic_field': 'dipole',
    'environment.sun': 'ephemeris',
    # In the light for more than ten minutes.
    'orbit.true_anomaly': 3.0,
    'sensors.names': NAMES,
    'sensors.seed': 3,
    'sensors.gyro.noise_density': 1e-4,
    'sensors.gyro.bias_random_walk': 1e-5,
    'sensors.star_tracker.cross_boresight': 1e-5,
    'sensors.star_tracker.divisor': 10,
    'sensors.star_tracker.latency': 3,
    'sensors.st2.type': 'star_tracker',
    'sensors.st2.roll': 1e-4,
    'sensors.st2.divisor': 5,
    'sensors.magnetometer.noise': 1e-7,
    'sensors.sun_sensor.noise': 1e-3,
    'sensors.coarse_sun_sensor.divisor': 2,
    'sensors.coarse_sun_sensor.noise': 100.0,
    'record.enabled': True,
}


def test_sensors_publish_what_the_engine_measures(live, tmp_path):
    """Requests, pauses and resets change no noise: the bytes are those of a run without them."""
    node, participant = live(VALUES | {'initial.angular_velocity': [0.0, 0.0, 0.0]})
    table = node.scenario.topic_table
    heard = {name: participant.listen(name, raw=True, table=table) for name in NAMES}
    participant.hear(heard['star_tracker'], 3)
    participant.switch('pause', True)
    participant.switch('pause', False)
    participant.hear(heard['star_tracker'], 3)
    first = bytes(heard['gyro'][0])
    packed = set()
    simulation = Simulation(node.scenario)
    _, samples = simulation.advance(20_000)
    for name in heard:
        rows = packer(name, node.scenario).pack(samples)
        rows = rows.rows if isinstance(rows, SparseMessages) else rows
        packed |= {row.tobytes() for row in rows}
    assert first in packed
    assert all(heard.values())
    assert all(set(map(bytes, messages)) <= packed for messages in heard.values())
    assert participant.trigger('reset')[0]
    participant.hear(heard['star_tracker'], 3)
    assert node.end()[0] == 0
    (bag,) = tmp_path.glob('satdyn_2*')
    verdict = verify(bag)
    assert verdict.is_true
    assert verdict.same_bytes
