"""The server of the page: files, one WebSocket, and the rule of access."""

import asyncio
import json
import logging
import signal
import time
from collections.abc import Awaitable, Callable, Mapping
from importlib.resources import files
from socket import gaierror
from typing import Any, Protocol

from aiohttp import WSCloseCode, WSMsgType, web
from aiohttp.http_exceptions import HttpProcessingError

from ..report import html
from .access_policy import AccessPolicy
from .hub import Browser, Hub

_LARGEST_REQUEST = 4096
_REQUESTS_PER_S, _REQUESTS_AT_ONCE = 5.0, 20.0
# Requests of a browser that wait for their answers; further ones are read later.
_MOST_WAITING = 16
# For half of it a browser may do nothing but draw: without a graphics processor that is slow.
_HEARTBEAT_S = 60.0

# Nothing from elsewhere, not inside another page; scripts set the styles of elements.
_HEADERS = {
    'Content-Security-Policy': "default-src 'none'; script-src 'self'; connect-src 'self'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data:; frame-ancestors 'none'; "
    "base-uri 'none'; form-action 'none'",
    'X-Content-Type-Options': 'nosniff',
    'Referrer-Policy': 'no-referrer',
    'Cross-Origin-Resource-Policy': 'same-origin',
    'Cache-Control': 'no-store',
}
_TYPES = {'js': 'text/javascript', 'css': 'text/css', 'html': 'text/html'}


class Source(Protocol):
    """What a page shows: a running node or a bag."""

    page: str
    files: tuple[str, ...]

    async def start(self, hub: Hub) -> None:
        """Start sending to the browsers."""

    async def stop(self) -> None:
        """End."""

    async def first(self) -> Mapping[str, str]:
        """Return the first messages for a new browser, by kind."""

    async def asked(self, request: dict[str, Any]) -> dict[str, Any]:
        """Return the answer to a browser's request; ValueError: it is not valid."""


class Server:
    """The pages of a source."""

    def __init__(self, source: Source, policy: AccessPolicy):
        self._source, self._policy, self._hub = source, policy, Hub()
        self._files = {name.split('/')[-1]: name for name in (*html.STYLE_SHEETS, *source.files)}

    def application(self) -> web.Application:
        """Return the aiohttp application."""
        application = web.Application(middlewares=[self._guard], client_max_size=_LARGEST_REQUEST)
        application.router.add_get('/', self._page)
        application.router.add_get('/socket', self._socket)
        application.router.add_get('/files/{name}', self._file)
        application.on_startup.append(lambda _: self._source.start(self._hub))
        application.on_shutdown.append(lambda _: self._hub.close())
        application.on_cleanup.append(lambda _: self._source.stop())
        return application

    @web.middleware
    async def _guard(
        self,
        request: web.Request,
        handler: Callable[[web.Request], Awaitable[web.StreamResponse]],
    ) -> web.StreamResponse:
        refusal = self._policy.refusal(request)
        if refusal is not None:
            return web.Response(status=403, text=refusal + '\n', headers=_HEADERS)
        return await handler(request)

    async def _page(self, request: web.Request) -> web.Response:
        links = ''.join(
            f'<link rel="stylesheet" href="files/{name}">'
            if name.endswith('.css')
            else f'<script src="files/{name}" defer></script>'
            for name in self._files
        )
        text = html.document('satdyn watch', links, asset(self._source.page))
        response = web.Response(text=text, content_type='text/html', headers=_HEADERS)
        self._policy.let_in(request, response)
        return response

    async def _file(self, request: web.Request) -> web.Response:
        name = self._files.get(request.match_info['name'])
        if name is None:
            return web.Response(status=404, text='there is no such file\n', headers=_HEADERS)
        kind = _TYPES[name.rsplit('.', 1)[1]]
        return web.Response(text=asset(name), content_type=kind, headers=_HEADERS)

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        if self._hub.is_full:
            return web.Response(
                status=503, text='too many browsers are connected\n', headers=_HEADERS
            )
        socket = web.WebSocketResponse(max_msg_size=_LARGEST_REQUEST, heartbeat=_HEARTBEAT_S)
        try:
            await socket.prepare(request)
        except ValueError:
            # aiohttp decodes the key, and repeats what else is wrong, as ASCII.
            return web.Response(status=400, text='the headers are not ASCII\n', headers=_HEADERS)
        browser = self._hub.enter(socket)
        sending = asyncio.create_task(browser.send())
        waiting: set[asyncio.Task[None]] = set()
        try:
            for kind, text in (await self._source.first()).items():
                browser.put(kind, text)
            allowed, at = _REQUESTS_AT_ONCE, time.monotonic()
            async for message in socket:
                now = time.monotonic()
                allowed = min(_REQUESTS_AT_ONCE, allowed + _REQUESTS_PER_S * (now - at)) - 1.0
                at = now
                if message.type != WSMsgType.TEXT or allowed < 0.0:
                    await socket.close(code=WSCloseCode.POLICY_VIOLATION)
                    break
                if len(waiting) == _MOST_WAITING:
                    await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
                task = asyncio.create_task(self._reply(browser, message.data))
                waiting.add(task)
                task.add_done_callback(waiting.discard)
        finally:
            self._hub.leave(browser)
            for task in (sending, *waiting):
                task.cancel()
        return socket

    async def _reply(self, browser: Browser, text: str) -> None:
        browser.answer(json.dumps(await self._answer(text)))

    async def _answer(self, text: str) -> dict[str, Any]:
        number = None
        try:
            request = json.loads(text)
            if not isinstance(request, dict):
                raise ValueError('a request must be an object')
            number = request.get('id')
            answer = await self._source.asked(request)
        except (ValueError, RecursionError, OSError) as error:
            answer = {'success': False, 'text': str(error)}
        return {'type': 'answer', 'id': number} | answer


def asset(name: str) -> str:
    """Return the text of a file of the pages, from here or from the report."""
    own = files(__package__).joinpath(name)
    return own.read_text(encoding='utf-8') if own.is_file() else html.asset(name)


def _is_fault_of_ours(record: logging.LogRecord) -> bool:
    """Whether aiohttp logs more than a request that is no HTTP, which is answered by a 400."""
    error = record.exc_info[1] if record.exc_info else None
    return not isinstance(error, HttpProcessingError | web.RequestPayloadError)


def serve(source: Source, host: str, port: int, opened: Callable[[str], None]) -> int:
    """
    Serve a source until SIGINT or SIGTERM, whose number is returned.

    opened gets the URL once it is open.  OSError: the port cannot be opened.  ValueError: the host
    is unknown.
    """
    logging.getLogger('aiohttp.server').addFilter(_is_fault_of_ours)
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.getsignal(number) for number in numbers]
    try:
        return asyncio.run(_serve(source, host, port, opened, numbers))
    except gaierror as error:
        raise ValueError(f'--host is {host}: {error.strerror}') from None
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)


async def _serve(
    source: Source,
    host: str,
    port: int,
    opened: Callable[[str], None],
    numbers: tuple[signal.Signals, ...],
) -> int:
    loop = asyncio.get_running_loop()
    ended: asyncio.Future[int] = loop.create_future()

    def end(number: int) -> None:
        if not ended.done():
            ended.set_result(number)

    for number in numbers:
        loop.add_signal_handler(number, end, number)
    policy = AccessPolicy(host, port)
    runner = web.AppRunner(
        Server(source, policy).application(), access_log=None, shutdown_timeout=1.0
    )
    await runner.setup()
    try:
        await web.TCPSite(runner, host, port).start()
        policy.port = runner.addresses[0][1]
        opened(policy.url)
        return await ended
    finally:
        await runner.cleanup()
