"""A node that is stopped holds those who ask it, for a bounded time, and nobody else."""

import asyncio
import json
import os
import signal
from urllib.parse import urlsplit

import aiohttp
import pytest
from ros.live import LiveNode

NAMESPACE = '/stopped'
VALUES = {'publish.rate': 50.0, 'publish.topics': ['odometry']}
# Long enough for a loaded machine, and less than what three questions in a row would take.
PATIENCE_S = 45.0
LATE = f'{NAMESPACE}/satdyn did not answer within 20 s'


@pytest.fixture
def node(tmp_path):
    node = LiveNode(tmp_path, VALUES, namespace=NAMESPACE)
    yield node
    node.process.send_signal(signal.SIGCONT)
    node.end()


class Browser:
    """A page's connection: asks, and hears the answers by their numbers."""

    def __init__(self, socket, order):
        self._socket, self._order = socket, order

    async def ask(self, number, **request):
        await self._socket.send_str(json.dumps({'id': number} | request))

    async def answer(self):
        """Return the next answer, whose number joins the order of all."""
        message = await self.hear(lambda message: message['type'] == 'answer')
        self._order.append(message['id'])
        return message

    async def hear(self, is_it):
        """Return the next message that is the one."""
        while True:
            message = await self._socket.receive_json(timeout=PATIENCE_S)
            if is_it(message):
                return message


@pytest.mark.long
def test_a_stopped_node(watch, node):
    """
    While it is stopped, pages open and what does not concern it is answered.

    All who asked it are answered together, in one sentence, not one after the other; when it goes
    on it answers again.  A question that is still open does not hold up the end of the command.
    """
    url = urlsplit(watch('--node', f'{NAMESPACE}/satdyn'))
    here = f'http://127.0.0.1:{url.port}'
    order: list[str] = []

    async def talk():
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f'{here}/socket', max_msg_size=0) as first,
            session.ws_connect(f'{here}/socket', max_msg_size=0) as second,
        ):
            one, other = Browser(first, order), Browser(second, order)
            await one.hear(lambda message: message['type'] == 'scene')
            await one.ask('before', do='pause')
            assert (await one.answer())['success']
            os.kill(node.process.pid, signal.SIGSTOP)
            await one.ask('one', do='resume')
            await one.ask('two', do='pause')
            await other.ask('three', do='pause')
            await one.ask('nonsense', do='fly')
            await other.ask('more nonsense', do='fly')
            assert 'do takes' in (await one.answer())['text']
            assert 'do takes' in (await other.answer())['text']
            async with session.get(here) as page:
                assert page.status == 200
            async with session.ws_connect(f'{here}/socket', max_msg_size=0) as third:
                await Browser(third, order).hear(lambda message: message['type'] == 'scene')
            order.append('a new page')
            late = [*await asyncio.gather(one.answer(), other.answer()), await one.answer()]
            assert [answer['text'] for answer in late] == 3 * [LATE]
            assert [answer['success'] for answer in late] == 3 * [False]
            os.kill(node.process.pid, signal.SIGCONT)
            await one.ask('after', do='pause')
            assert (await one.answer())['success']
            os.kill(node.process.pid, signal.SIGSTOP)
            await one.ask('open', do='resume')
            await one.ask('nonsense again', do='fly')
            await one.answer()

    asyncio.run(asyncio.wait_for(talk(), 4.0 * PATIENCE_S))
    assert order[:4] == ['before', 'nonsense', 'more nonsense', 'a new page']
    assert set(order[4:7]) == {'one', 'two', 'three'}
    # The question that is open would take 20 s.
    process = watch.running[-1]
    process.send_signal(signal.SIGINT)
    process.wait(15)
