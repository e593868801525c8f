"""What lets a controller pass ticks one by one, so that no message is lost or late."""

import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from std_srvs.srv import SetBool, Trigger

# Anything that takes longer than this has failed.
PATIENCE_S = 60.0


class Stepping(Node):
    """
    A controller that lets a tick pass once its command has been sent.

    It is mixed into the controller's class, whose act() publishes one command for each sample.
    """

    command: Publisher
    state_subscriptions: list[Subscription]

    def __init__(self, *arguments, **named):
        super().__init__(*arguments, **named)
        self._heard = self._flies = False
        self._sent = self._accepted_before = 0
        self._reported: dict[str, str] = {}
        self._pause = self.create_client(SetBool, 'satdyn/pause')
        self._step = self.create_client(Trigger, 'satdyn/step')
        self.create_subscription(DiagnosticArray, '/diagnostics', self._take_diagnostics, 10)

    def begin(self):
        """Wait until node and controller have discovered each other, then stop the ticks."""
        for client in (self._pause, self._step):
            self._wait(client.service_is_ready, 'the services of the node did not appear')
        self._wait(lambda: self._is_connected, 'the topics of the node were not connected')
        self._wait(lambda: self._says('tick') >= 0, 'the node did not begin')
        self._accepted_before = self._says('accepted')
        self._call(self._pause, SetBool.Request(data=True))
        self._flies = True
        self.pass_tick()

    def end(self):
        """Make sure that the node has accepted each command."""
        sent = self._accepted_before + self._sent
        self._wait(lambda: self._says('accepted') == sent, 'a command was lost')

    def act(self, *sample):
        """Publish the command for the next tick, once ticks pass only on request."""
        if not self._flies:
            return
        super().act(*sample)  # type: ignore[misc]  # of the controller
        self._sent += 1
        self._heard = True

    def pass_tick(self):
        """Let one tick pass, with the command that was published last, and act on its sample."""
        # The request follows the command on the same path, and the node reads commands first.
        self._heard = False
        self._call(self._step, Trigger.Request())
        self._wait(lambda: self._heard, 'the sample of a tick did not come')

    @property
    def _is_connected(self):
        """
        Whether each side has found the other.

        Discovery goes both ways, and one side may be ready before the other: a command published
        then would be lost.  The node's diagnostics say how many it has found.
        """
        own = f'{self.get_namespace().rstrip("/")}/'
        command = self.command.topic_name.removeprefix(own)
        states = [heard.topic_name.removeprefix(own) for heard in self.state_subscriptions]
        return (
            self.command.get_subscription_count() > 0
            and all(heard.get_publisher_count() > 0 for heard in self.state_subscriptions)
            and self._says(f'publishers of {command}') >= self.count_publishers(command)
            and all(
                self._says(f'subscribers of {state}') >= self.count_subscribers(state)
                for state in states
            )
        )

    def _take_diagnostics(self, message):
        own = f'{self.get_namespace()}/satdyn: '.lstrip('/')
        for status in message.status:
            if status.name.startswith(own):
                self._reported |= {pair.key: pair.value for pair in status.values}

    def _says(self, name):
        """Return an integer from the node's diagnostics, -1 before it is there."""
        return int(self._reported.get(name, -1))

    def _call(self, client, request):
        future = client.call_async(request)
        self._wait(future.done, 'the node did not answer')
        if not future.result().success:
            raise SystemExit(future.result().message)

    def _wait(self, condition, otherwise):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            if time.monotonic() > end:
                raise SystemExit(otherwise)
            rclpy.spin_once(self, timeout_sec=0.1)
