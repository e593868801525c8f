"""The command `satdyn_lifecycle_node`: satellites as managed nodes, driven by `ros2 lifecycle`."""

import gc
import sys
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn

from ..base.sentences import one_sentence
from . import start
from .node import SatdynNode

_HELD = 'the node is inactive; ticks pass while it is active'
_KINDS = 'publisher', 'subscription', 'service', 'timer'


def main(argv: Sequence[str] | None = None) -> int:
    """Run the nodes, unconfigured, and return the exit code; argv: as of `satdyn_node`."""
    return start.main(argv, ManagedSatdynNode, begins=False)


class ManagedSatdynNode(SatdynNode, LifecycleNodeMixin):
    """
    A satellite as a managed node, whose ticks follow the transitions of its lifecycle.

    configure reads the scenario and builds what it describes; activate begins with tick 0, or lets
    ticks pass again; deactivate lets none pass; cleanup and shutdown complete the bag and take
    back what was built.  What fails is logged in a sentence and leaves the node unconfigured.
    """

    def _start(self, begins: bool) -> None:
        """Wait to be configured."""
        LifecycleNodeMixin.__init__(self)
        change_state = self._service_change_state.callback

        def answer(request: Any, response: Any) -> Any:
            try:
                return change_state(request, response)
            except rclpy_implementation.RCLError as error:
                self.get_logger().error(one_sentence(error))
                response.success = False
                return response

        self._service_change_state.callback = answer
        self._entities_before = self._all_entities()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the scenario and build what it describes."""

        def build():
            scenario = self._read()
            self._entities_before = self._all_entities()
            self._prepare(scenario)

        return self._tried(build)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin with tick 0, or let ticks pass again."""
        if self._own_services is None:
            return self._tried(self.begin)
        self._own_services.held = ''
        if refusal := self._own_services.pause(False):
            self._own_services.held = _HELD
            self.get_logger().error(refusal)
            return TransitionCallbackReturn.FAILURE
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let no tick pass."""
        assert self._own_services is not None  # it was active
        self._own_services.held = _HELD
        self._own_services.pause(True)
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Complete the bag, and take back what was built."""
        self._end()
        for kind in _KINDS:
            for entity in self._entities(kind) - self._entities_before[kind]:
                getattr(self, f'destroy_{kind}')(entity)
        # Those of publishers and subscriptions have gone with them.
        for action in self._entities('waitable') - self._entities_before['waitable']:
            action.destroy()
        if self._own_parameters is not None:
            self._own_parameters.withdraw()
        self._forget()
        # What was built is garbage now.
        gc.unfreeze()
        return TransitionCallbackReturn.SUCCESS

    on_shutdown = on_error = on_cleanup

    def _entities(self, kind: str) -> set[Any]:
        return set(getattr(self, f'{kind}s'))

    def _all_entities(self) -> dict[str, set[Any]]:
        return {kind: self._entities(kind) for kind in (*_KINDS, 'waitable')}

    def _tried(self, act: Callable[[], None]) -> TransitionCallbackReturn:
        """Return how an act went; rclpy itself would not report an exception."""
        try:
            act()
        except Exception as error:
            is_expected = isinstance(error, OSError | ValueError)
            self.get_logger().error(one_sentence(error if is_expected else repr(error)))
            return TransitionCallbackReturn.ERROR
        return TransitionCallbackReturn.SUCCESS


if __name__ == '__main__':
    sys.exit(main())
