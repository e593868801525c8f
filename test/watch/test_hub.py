"""A slow browser costs the others nothing: neither frames nor memory."""

import asyncio
import json
import socket as sockets
import tracemalloc

import aiohttp
from aiohttp import web

from satdyn_ros.watch.access_policy import AccessPolicy
from satdyn_ros.watch.server import Server

FRAMES = 300
FRAME_SIZE = 200_000


class Beacon:
    """A source of large frames with a number each."""

    page = 'page/bag.html'
    files: tuple[str, ...] = ()

    async def start(self, hub):
        self.hub = hub

    async def stop(self):
        pass

    async def first(self):
        return {}

    async def asked(self, request):
        return {'success': True, 'text': ''}


async def deaf(port):
    """Return the connection of a browser that shakes hands and never reads again."""
    connection = sockets.create_connection(('127.0.0.1', port))
    connection.sendall(
        f'GET /socket HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: Upgrade\r\n'
        'Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n'
        'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n'.encode()
    )
    return connection


async def watched():
    """Show 60 MB of frames to a deaf browser and a good one; return what the good one got."""
    source = Beacon()
    runner = web.AppRunner(Server(source, AccessPolicy('127.0.0.1', 0)).application())
    await runner.setup()
    await web.TCPSite(runner, '127.0.0.1', 0).start()
    port = runner.addresses[0][1]
    stuck = await deaf(port)
    got = []
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(f'http://127.0.0.1:{port}/socket', max_msg_size=0) as socket,
    ):
        while len(source.hub) < 2:
            await asyncio.sleep(0.01)
        tracemalloc.start()
        for number in range(FRAMES):
            text = json.dumps({'type': 'rows', 'number': number, 'filler': 'x' * FRAME_SIZE})
            source.hub.put('rows', text)
            got.append(json.loads((await socket.receive(timeout=60)).data)['number'])
        largest = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    stuck.close()
    await runner.cleanup()
    return got, largest


def test_slow_browser_costs_the_others_nothing():
    """The good browser gets every frame; of the 60 MB for the deaf one a few frames are kept."""
    got, largest = asyncio.run(watched())
    assert got == list(range(FRAMES))
    # The frame in flight, the one that waits, what the other browser reads: copies of a few.
    assert largest < 40 * FRAME_SIZE


def test_late_frames_are_dropped():
    """A browser that was away gets the newest frame, not those that it missed, and its answers."""

    async def miss():
        source = Beacon()
        runner = web.AppRunner(Server(source, AccessPolicy('127.0.0.1', 0)).application())
        await runner.setup()
        await web.TCPSite(runner, '127.0.0.1', 0).start()
        port = runner.addresses[0][1]
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f'http://127.0.0.1:{port}/socket') as socket,
        ):
            while not len(source.hub):
                await asyncio.sleep(0.01)
            for number in range(100):
                source.hub.put('rows', json.dumps({'type': 'rows', 'number': number}))
            first = json.loads((await socket.receive(timeout=60)).data)['number']
            await socket.send_str('{"id": 5}')
            answer = json.loads((await socket.receive(timeout=60)).data)
        await runner.cleanup()
        return first, answer

    first, answer = asyncio.run(miss())
    assert first == 99
    assert (answer['type'], answer['id'], answer['success']) == ('answer', 5, True)


async def put_at_once(*messages):
    """Return what a browser gets of messages that are there before it can be sent one."""
    source = Beacon()
    runner = web.AppRunner(Server(source, AccessPolicy('127.0.0.1', 0)).application())
    await runner.setup()
    await web.TCPSite(runner, '127.0.0.1', 0).start()
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(f'http://127.0.0.1:{runner.addresses[0][1]}/socket') as socket,
    ):
        while not len(source.hub):
            await asyncio.sleep(0.01)
        for kind, text in messages:
            source.hub.put(kind, text)
        got = [(await socket.receive(timeout=60)).data for _ in {kind for kind, _ in messages}]
    await runner.cleanup()
    return got


def test_a_row_comes_after_the_start_that_it_belongs_to():
    """Though an older row waited before the start: a paused node has no other row to show."""
    messages = ('rows', 'row of 1'), ('scene', 'start 2'), ('rows', 'row of 2')
    assert asyncio.run(put_at_once(*messages)) == ['start 2', 'row of 2']
