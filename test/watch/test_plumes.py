"""Plumes of thrusters on the live page of a node."""

import math

import browser as pages
from geometry_msgs.msg import WrenchStamped
from ros.live import LiveNode, Participant
from ros.test_inputs import wrench
from ros.test_thruster_command import PAIR, on_times
from trajectory_msgs.msg import JointTrajectory

NAMESPACE = '/fired'


def test_a_plume_is_there_while_its_valve_is_open(ros, tmp_path, watch, browser):
    """Commanded by whomever: of the one that fires, and no longer than it does."""
    node = LiveNode(tmp_path, PAIR | {'publish.topics': ['imu']}, namespace=NAMESPACE)
    participant = Participant(NAMESPACE)
    try:
        browser.get(watch('--node', f'{NAMESPACE}/satdyn'))
        pages.wait(browser, 'window.satdyn && satdyn.rows.length > 5')
        seen = 'satdyn.stage.scene.plumes.map(({ visible }) => visible)'
        assert pages.wait(browser, seen) == [False, False]
        publisher = participant.node.create_publisher(JointTrajectory, 'thruster_command', 10)
        # The node and the page.
        participant.wait_until(lambda: publisher.get_subscription_count() == 2)
        publisher.publish(on_times(b=2000.0))
        pages.wait(browser, f'String({seen}) === "false,true"')
        publisher.publish(on_times(b=0.0))
        pages.wait(browser, f'String({seen}) === "false,false"')
        assert pages.errors(browser) == []
    finally:
        participant.close()
        node.end()


def test_of_commands_between_two_frames_each_acts_unless_the_node_refuses_it(
    ros, tmp_path, watch, browser
):
    """
    Thrusters may be commanded one by one; the refused ones before them change nothing.

    An unknown thruster, a torque in another frame, and one that is not finite.
    """
    node = LiveNode(tmp_path, PAIR | {'publish.topics': ['imu']}, namespace='/one_by_one')
    participant = Participant('/one_by_one')
    try:
        browser.get(watch('--node', '/one_by_one/satdyn'))
        pages.wait(browser, 'window.satdyn && satdyn.rows.length > 5')
        thrusters = participant.node.create_publisher(JointTrajectory, 'thruster_command', 10)
        torques = participant.node.create_publisher(WrenchStamped, 'torque', 10)
        for publisher in (thrusters, torques):
            participant.wait_until(lambda p=publisher: p.get_subscription_count() == 2)
        torques.publish(wrench((1.0, 0.0, 0.0), 'lvlh'))
        torques.publish(wrench((math.nan, 0.0, 0.0)))
        for name in ('c', 'a', 'b'):
            thrusters.publish(on_times(**{name: 2000.0}))
        seen = 'String(satdyn.stage.scene.plumes.map(({ visible }) => visible))'
        pages.wait(browser, f'{seen} === "true,true"')
        assert pages.wait(browser, 'String(satdyn.stage.scene.row.applied_b)') == 'undefined'
        assert pages.errors(browser) == []
    finally:
        participant.close()
        node.end()


def test_the_propellant_used_is_said_beside_its_thruster(ros, tmp_path, watch, browser):
    """As the node publishes it: thrust times on-time over g Isp."""
    topics = {'publish.topics': ['imu', 'thruster']}
    node = LiveNode(tmp_path, PAIR | topics, namespace='/fuelled')
    participant = Participant('/fuelled')
    try:
        browser.get(watch('--node', '/fuelled/satdyn'))
        pages.wait(browser, 'window.satdyn && satdyn.rows.length > 5')
        publisher = participant.node.create_publisher(JointTrajectory, 'thruster_command', 10)
        participant.wait_until(lambda: publisher.get_subscription_count() == 2)
        publisher.publish(on_times(a=0.5))
        used_g = 1000.0 * 3.0 * 0.5 / (9.80665 * 50.0)
        used = '1000 * satdyn.stage.scene.row.propellant?.[0]'
        pages.wait(browser, f'Math.abs({used} - {used_g}) < 1e-3')
        labels = '[...document.querySelectorAll(".label")]'
        said = f'{labels}.some(({{ textContent }}) => /^a 3.06 g used/.test(textContent))'
        pages.wait(browser, said)
        assert pages.errors(browser) == []
    finally:
        participant.close()
        node.end()
