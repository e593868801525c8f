"""What a page of the graph shows."""

from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray

from ..run.scenario import Scenario

# Sends pages a message of a kind; whether pages that are opened later get it too.
Send = Callable[[str, dict[str, Any], bool], None]


class View:
    """
    Nothing: no satellite is there.  A satellite, and all of them, are views too.

    name: that of the node, or what a browser chooses in place of one; '': there is none.
    frame_s: the time from one frame to the next [s].
    """

    name = ''
    frame_s = 1.0

    @property
    def refusal(self) -> str:
        """Why nothing can be asked; '': the node can."""
        return 'no satellite is there'

    def look(self, found: list[str]) -> None:
        """See what has changed in the graph, where these satellites were found."""

    def take_scenario(self, name: str, scenario: Scenario | str) -> None:
        """Take the parameters of a node that was asked, or why they are not understood."""

    def take_change(self, name: str) -> None:
        """Take it that parameters of a node have changed."""

    def take_diagnostics(self, message: DiagnosticArray) -> None:
        """Take what nodes report."""

    def take_pause(self, is_paused: bool) -> None:
        """Take the node's answer to a pause, or to its end."""

    def frame(self) -> None:
        """Send the page what is new."""

    def history(self) -> dict[str, str]:
        """Return what a new page needs of the past, messages by their type."""
        return {}

    def status(self) -> dict[str, Any]:
        """Return what the page says of the node, plain data."""
        return {
            'is_there': False,
            'is_paused': False,
            'has_namesakes': False,
            'bag': None,
            'missing': [],
            'diagnostics': {},
        }
