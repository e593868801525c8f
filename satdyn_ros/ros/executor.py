"""The executor of a node, which survives any message."""

from collections.abc import Callable
from typing import Any

from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from ..base.sentences import one_sentence

# The same kind of failure is logged at most this often.
_QUIET_S = 10.0


class Executor(SingleThreadedExecutor):
    """
    An executor of one node that logs an exception and continues.

    A message that rclpy cannot deserialise, or that makes a callback fail, is dropped.
    """

    def __init__(self, node: Node):
        super().__init__()
        self._log = node.get_logger()
        self.add_node(node)

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait for one callback and execute it."""
        try:
            super().spin_once(timeout_sec)
        except ExternalShutdownException:
            raise
        except Exception as error:
            if not self.context.ok():
                raise
            self._report(f'a callback failed: {one_sentence(repr(error))}')

    # An exception where rclpy takes a message would leave its callback group locked for good.

    def _take_service(self, service: Any) -> Any:
        return self._taken(super()._take_service, service)

    def _take_subscription(self, subscription: Any) -> Any:
        return self._taken(super()._take_subscription, subscription)

    def _taken(self, take: Callable[[Any], Any], entity: Any) -> Any:
        try:
            return take(entity)
        except Exception as error:
            self._report(f'a message cannot be read: {one_sentence(repr(error))}')
            return None

    def _report(self, sentence: str) -> None:
        self._log.error(sentence, throttle_duration_sec=_QUIET_S)
