"""Random programs of live nodes: each bag proves itself, whatever is asked at whichever moment."""

import time

import pytest
from geometry_msgs.msg import WrenchStamped
from programs import Draw, Program, motors_of
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from ros.live import Participant, parameter_messages, raw_stamp_ns
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag

# Code for several rotors is compiled by the long ones.
SHORT = [13, *(pytest.param(seed, marks=pytest.mark.long) for seed in (0, 1))]
LONG = range(100, 200)
SERVICES = {
    'set_initial_conditions': SetParametersAtomically,
    'set_parameters': SetParameters,
    'reset': Trigger,
    'pause': SetBool,
    'step': Trigger,
    'record': SetBool,
}
# A tick under a torque that is dropped costs seconds of a loaded machine.
PATIENCE_S = 300.0


class Pilot:
    """
    Two participants who ask a node without waiting for each other; all they do is drawn.

    answers: not yet come: who asked, the future, what was asked, and whether it is to succeed.
    log: what was done, for whoever reads why a program failed.
    """

    def __init__(self, draw, node, participant):
        self.draw, self.participants = draw, (participant, Participant(node.namespace))
        self.given = self.conditions = node.scenario
        self.is_recording = self.conditions['record.enabled']
        self.is_paused = False
        self.bags: list[str] = []
        self.answers: list[tuple] = []
        self.log: list[str] = []
        self.begin_s = time.monotonic()
        self.clients = [
            {
                name: each.node.create_client(kind, f'satdyn/{name}')
                for name, kind in SERVICES.items()
            }
            for each in self.participants
        ]
        self.torque = {
            topic: participant.node.create_publisher(WrenchStamped, topic, 10)
            for topic in node.scenario.inputs
            if topic.startswith('torque')
        }
        self.command = participant.node.create_publisher(JointState, 'rotor_command', 10)
        self.heard = participant.listen('attitude', raw=True)
        for each, clients in zip(self.participants, self.clients, strict=True):
            for name, client in clients.items():
                each.wait_until(client.service_is_ready, name, PATIENCE_S)
            each.wait_until_known('satdyn')
        for torque in self.torque.values():
            participant.wait_until(torque.get_subscription_count, 'the node')

    def __str__(self):
        """Return the scenario that was given and what was done."""
        return '\n'.join([str(Program(self.given, 0, [])), *self.log])

    def close(self):
        """Leave; the other participant belongs to the test."""
        self.participants[1].close()

    # -- asking ----------------------------------------------------------------------------------

    def ask(self, name, succeeds=True, who=0, **fields):
        """Ask, without waiting for the answer."""
        self.note(f'{name} {fields or ""}' + ('' if succeeds else ', to be refused'))
        if 'parameters' in fields:
            fields['parameters'] = parameter_messages(fields['parameters'])
        future = self.clients[who][name].call_async(SERVICES[name].Request(**fields))
        self.answers.append((self.participants[who], future, name, succeeds))

    def note(self, what):
        """Keep what was done, and when."""
        self.log.append(f'{time.monotonic() - self.begin_s:7.3f} s: {what}')

    def settle(self):
        """Wait for all answers, and assert that they are as they should be."""
        for participant, future, name, succeeds in self.answers:
            participant.wait_until(future.done, f'the answer of {name}', PATIENCE_S)
            answer = future.result()
            match name:
                case 'set_parameters':
                    (result,) = answer.results
                    done, sentence = result.successful, result.reason
                case 'set_initial_conditions':
                    done, sentence = answer.result.successful, answer.result.reason
                case _:
                    done, sentence = answer.success, answer.message
            self.note(f'    {name}: {done} {sentence}')
            assert done == succeeds, f'{name}: {sentence}'
            if name == 'record' and sentence.startswith('recording '):
                self.bags.append(sentence.removeprefix('recording '))
        self.answers.clear()

    def set(self, values, who=1):
        self.ask('set_parameters', who=who, parameters=values)

    # -- what happens ----------------------------------------------------------------------------

    def act(self):
        """Do something."""
        draw = self.draw
        kinds = (
            'torques torques commands limits request refused reset pause step topics topics '
            'timeout factor record record topics_and_record new_bag_and_topics'
        )
        getattr(self, draw.choice(kinds.split()))()
        if draw.one_in(2):
            self.settle()
        if draw.one_in(2):
            draw.choice(self.participants).spin(draw.choice((0.001, 0.02, 0.1, 0.3)))

    def torques(self):
        """Publish torques, one after the other at once."""
        for _ in range(self.draw.choice((1, 1, 2, 5))):
            message = WrenchStamped()
            # By the end of a program as fast as any body of these.
            torque = self.draw.torque(self.conditions, 3.0 * self.conditions['time.factor'])
            message.wrench.torque.x, message.wrench.torque.y, message.wrench.torque.z = torque
            topic = self.draw.choice(list(self.torque))
            self.note(f'{topic} {torque}')
            self.torque[topic].publish(message)

    def commands(self):
        """Publish commands to motors, one after the other at once."""
        motors = motors_of(self.conditions)
        for _ in range(self.draw.choice((1, 1, 2, 5)) if motors else 0):
            self.publish_command(self.draw.command(motors, self.conditions))

    def publish_command(self, command):
        self.note(f'command {command}')
        self.command.publish(JointState(name=list(command), effort=list(command.values())))

    def limits(self):
        """Drive a motor to its largest speed, and let something else happen while it is there."""
        motors = [rotor for rotor in motors_of(self.conditions) if rotor.max_speed]
        if not motors:
            return
        # As the scenario has it; the factor may have changed a little.
        tick_wall_s = 1.0 / self.conditions.ticks_per_wall_s
        rotor = self.draw.choice(motors)
        in_a_tick = rotor.inertia * rotor.max_speed * float(self.conditions.rate)
        torque = self.draw.sign() * in_a_tick * self.draw.choice((1.0, 0.3))
        for _ in range(20):
            self.publish_command({rotor.label: torque})
            self.participants[0].spin(min(self.draw.uniform(0.0, 2.0) * tick_wall_s, 0.1))
            match self.draw.randrange(12):
                case 0 | 1:
                    self.publish_command({rotor.label: 0.0})
                case 2 | 3 | 4:
                    self.publish_command({rotor.label: -0.01 * torque})
                case 5:
                    self.reset()
                case 6:
                    self.request()

    def request(self):
        """Ask for initial conditions that are allowed."""
        values = self.draw.request(self.conditions)
        self.conditions = self.conditions.with_values(values)
        self.ask('set_initial_conditions', parameters=values)

    def refused(self):
        """Ask for initial conditions that are not allowed."""
        values = self.draw.bad_request(self.conditions)
        self.ask('set_initial_conditions', False, parameters=values)

    def reset(self):
        self.ask('reset')

    def pause(self):
        """Pause, or let ticks pass again; whether a step succeeds depends on it."""
        self.settle()
        self.is_paused = not self.is_paused
        self.ask('pause', data=self.is_paused)
        self.settle()

    def step(self):
        """Let some ticks pass by a step, which is refused while not paused."""
        self.set({'step.ticks': self.draw.choice((1, 2, 7))})
        self.settle()
        self.ask('step', self.is_paused)
        if self.draw.one_in(2):
            self.torques()
        self.settle()

    def topics(self):
        """Publish other topics, none at times."""
        self.set({'publish.topics': self.draw.topics(self.conditions.is_fixed)})

    def timeout(self):
        tick_s = 1.0 / float(self.conditions.rate)
        timeouts_s = (0.0, 0.3 * tick_s, 5 * tick_s, 1.0)
        self.set({'torque.timeout': self.draw.choice(timeouts_s)})

    def factor(self):
        """Let time pass at another pace, for a moment as fast as possible at times."""
        usual = self.conditions['time.factor']
        if self.draw.one_in(3):
            self.set({'time.factor': 0.0})
        self.set({'time.factor': usual * self.draw.choice((0.3, 1.0, 3.0))})

    def record(self):
        """Open a bag, or close the open one."""
        self.is_recording = not self.is_recording
        self.ask('record', data=self.is_recording)

    def topics_and_record(self):
        """Publish other topics and open or close a bag, at once and in either order."""
        both = [self.topics, self.record]
        self.draw.shuffle(both)
        for each in both:
            each()

    def new_bag_and_topics(self):
        """Close a bag and open another, while other topics are published."""
        self.record()
        self.topics()
        self.record()
        self.topics()


def fly(seed, live, tmp_path):
    """Fly the program of a seed, and assert that each of its bags holds what happened."""
    draw = Draw(seed)
    scenario = draw.scenario()
    while draw.one_in(2) and not any(rotor.max_speed for rotor in motors_of(scenario)):
        scenario = draw.scenario()
    values = dict(scenario.values) | {
        'time.factor': draw.power(1.0, 2.7) / float(scenario.rate),
        'record.enabled': draw.one_in(2),
        'torque.names': draw.choice(((), ('control', 'drag'))),
    }
    node, participant = live(values)
    pilot = Pilot(draw, node, participant)
    try:
        for _ in range(draw.randint(10, 40)):
            pilot.act()
        pilot.settle()
    except AssertionError as error:
        raise AssertionError(f'{error}\n{pilot}') from error
    finally:
        pilot.close()
    code, errors = node.end()
    assert code == 0, f'{errors}\n{pilot}'
    assert 'Traceback' not in errors, f'{errors}\n{pilot}'
    bags = {bag.name: bag for bag in tmp_path.glob('satdyn_*_*')}
    assert {*pilot.bags} <= {*bags}, f'{pilot}'
    # What was open from the start has no answer that names it.
    assert len(bags) == len(pilot.bags) + values['record.enabled'], f'{pilot}'
    for bag in bags.values():
        for path in (bag, *sorted(bag.glob('*.mcap'))):
            verdict = verify(path)
            assert verdict.is_true, f'{path.name}: {verdict}\n{pilot}'
            assert verdict.same_bytes, f'{path.name}: {verdict}\n{pilot}'
    if pilot.is_recording:
        (last,) = pilot.bags[-1:] or bags
        assert_holds_the_end(bags[last], pilot, f'{node.namespace}/attitude')


def assert_holds_the_end(bag, pilot, topic):
    """
    Assert that the bag that was open at the end has the last message that was heard.

    The rerun cannot show it: it ends with the bag.
    """
    has_any = topic in Bag(bag).topics
    stamps_ns = Bag(bag).messages(topic).log_times_ns.tolist() if has_any else []
    heard_ns = [raw_stamp_ns(data) for data in pilot.heard]
    heard = {stamp for stamp in heard_ns if stamps_ns and stamp >= stamps_ns[0]}
    assert heard <= {*stamps_ns}, f'{pilot}'


@pytest.mark.parametrize('seed', SHORT)
def test_a_live_program_proves_itself(seed, live, tmp_path):
    """The node ends well; each of its bags verifies with the same bytes, each file alone too."""
    fly(seed, live, tmp_path)


@pytest.mark.torture
@pytest.mark.parametrize('seed', LONG)
def test_a_hundred_live_programs_prove_themselves(seed, live, tmp_path):
    """The same with other seeds."""
    fly(seed, live, tmp_path)
