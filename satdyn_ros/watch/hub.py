"""The connected browsers: each gets the newest message of each kind, at its own pace."""

import asyncio
from collections import deque
from contextlib import suppress

from aiohttp import WSCloseCode, web

_MOST_BROWSERS = 64
_MOST_ANSWERS = 16
_PATIENCE_S = 20.0


class Browser:
    """One open page: a slot for the newest message of each kind, and a queue of answers."""

    def __init__(self, socket: web.WebSocketResponse):
        self._socket = socket
        self._newest: dict[str, str] = {}
        self._answers: deque[str] = deque(maxlen=_MOST_ANSWERS)
        self._something = asyncio.Event()

    def put(self, kind: str, text: str) -> None:
        """Put a message in place of an older one of its kind that has not been sent yet."""
        # Behind all others: a row comes after the start that it belongs to.
        self._newest.pop(kind, None)
        self._newest[kind] = text
        self._something.set()

    def answer(self, text: str) -> None:
        """Queue the answer to a request."""
        self._answers.append(text)
        self._something.set()

    async def send(self) -> None:
        """Send whatever is there, until the browser closes."""
        with suppress(ConnectionError, asyncio.TimeoutError):
            while not self._socket.closed:
                await self._something.wait()
                self._something.clear()
                texts = [*self._answers, *self._newest.values()]
                self._answers.clear()
                self._newest.clear()
                for text in texts:
                    await asyncio.wait_for(self._socket.send_str(text), _PATIENCE_S)
        await self._socket.close(code=WSCloseCode.TRY_AGAIN_LATER)


class Hub:
    """All browsers, and what a new one must receive first."""

    def __init__(self) -> None:
        self._browsers: set[Browser] = set()
        self._lasting: dict[str, str] = {}

    @property
    def is_full(self) -> bool:
        """Whether the maximum number of browsers is connected."""
        return len(self._browsers) >= _MOST_BROWSERS

    def __len__(self) -> int:
        return len(self._browsers)

    def put(self, kind: str, text: str, is_lasting: bool = False) -> None:
        """Send a message to all browsers; a lasting one goes to later browsers too."""
        if is_lasting:
            self._lasting[kind] = text
        for browser in self._browsers:
            browser.put(kind, text)

    def enter(self, socket: web.WebSocketResponse) -> Browser:
        """Add a browser."""
        browser = Browser(socket)
        for kind, text in self._lasting.items():
            browser.put(kind, text)
        self._browsers.add(browser)
        return browser

    def leave(self, browser: Browser) -> None:
        """Remove a browser."""
        self._browsers.discard(browser)

    async def close(self) -> None:
        """Disconnect all browsers."""
        for browser in list(self._browsers):
            with suppress(ConnectionError):
                await browser._socket.close(code=WSCloseCode.GOING_AWAY)
