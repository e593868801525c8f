"""Who is let in: requests as a browser, another site's page and a stranger would send them."""

import asyncio
import http.client
import json
import socket
from http.client import HTTPMessage
from typing import NamedTuple
from urllib.parse import urlsplit

import aiohttp
import pytest

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.cli.main import main
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.watch.access_policy import AccessPolicy

UPGRADE = {
    'Connection': 'Upgrade',
    'Upgrade': 'websocket',
    'Sec-WebSocket-Version': '13',
    'Sec-WebSocket-Key': 'dGhlIHNhbXBsZSBub25jZQ==',
}


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp('door') / 'bag'
    for _ in simulate(Scenario.from_dict({'time': {'epoch_ns': 10**18}}), 1, path):
        pass
    return str(path)


@pytest.fixture(scope='module')
def here(watch, bag):
    """Return the URL of a server on loopback."""
    return urlsplit(watch(bag))


@pytest.fixture(scope='module')
def there(watch, bag):
    """Return the URL of a server that listens to the net."""
    return urlsplit(watch(bag, '--host', '0.0.0.0'))


class Answer(NamedTuple):
    """What a server says; the text is empty where it changes the protocol."""

    status: int
    headers: HTTPMessage
    text: str


def ask(url, path='/', headers=None) -> Answer:
    """Return the answer to a request as it is, cookies and all."""
    connection = http.client.HTTPConnection('127.0.0.1', url.port, timeout=60)
    connection.request('GET', path, headers=headers or {})
    answer = connection.getresponse()
    text = '' if answer.status == 101 else answer.read().decode()
    connection.close()
    return Answer(answer.status, answer.headers, text)


def test_page_and_files(here):
    """On loopback the page comes without a token, forbids frames, and loads its own alone."""
    answer = ask(here)
    assert answer.status == 200
    policy = answer.headers['Content-Security-Policy']
    assert "default-src 'none'" in policy
    assert "frame-ancestors 'none'" in policy
    assert ask(here, '/files/three.min.js').status == 200
    assert ask(here, '/files/..%2f..%2fsetup.py').status == 404
    assert ask(here, '/socket', UPGRADE).status == 101


@pytest.mark.parametrize('path', ['/', '/socket', '/files/scene.js'])
def test_foreign_host_is_refused(here, path):
    """A name of somebody else's that leads to this machine is no way in."""
    for host in ('evil.example', f'evil.example:{here.port}', '127.0.0.1.evil.example', '[::'):
        assert ask(here, path, UPGRADE | {'Host': host}).status in (400, 403)
    assert ask(here, '/', {'Host': f'localhost:{here.port}'}).status == 200


@pytest.mark.parametrize('path', ['/', '/socket', '/files/scene.js'])
def test_foreign_origin_is_refused(here, there, path):
    """A page of another origin is refused, also of another port, and with the token."""
    for url in (here, there):
        own = f'http://127.0.0.1:{url.port}'
        for origin in ('https://evil.example', 'null', 'http://127.0.0.1:1', own + '0'):
            answer = ask(url, f'{path}?{url.query}', UPGRADE | {'Origin': origin})
            assert (answer.status, 'another origin' in answer.text) == (403, True)
    assert (
        ask(here, '/socket', UPGRADE | {'Origin': f'http://127.0.0.1:{here.port}'}).status == 101
    )


def test_token(there):
    """On the net nothing comes without the token: in the URL once, then as a strict cookie."""
    for path in ('/', '/socket', '/files/scene.js'):
        assert ask(there, path, UPGRADE).status == 403
        assert ask(there, f'{path}?token=wrong', UPGRADE).status == 403
    answer = ask(there, f'/?{there.query}', {'Host': 'satellite.example'})
    assert answer.status == 200
    cookie = answer.headers['Set-Cookie']
    assert 'SameSite=Strict' in cookie
    assert 'HttpOnly' in cookie
    kept = {'Cookie': cookie.split(';')[0]}
    assert ask(there, '/', kept).status == 200
    assert ask(there, '/socket', UPGRADE | kept).status == 101
    wrong = {'Cookie': cookie.split('=')[0] + '=wrong'}
    assert ask(there, '/socket', UPGRADE | wrong).status == 403


def closed(url, messages):
    """Send messages and return the code with which the server closes, with its answers."""

    async def talk():
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f'http://127.0.0.1:{url.port}/socket', max_msg_size=0) as socket,
        ):
            answers: list[str] = []
            for message in messages:
                await socket.send_str(message)
            while True:
                received = await socket.receive(timeout=60)
                if received.type != aiohttp.WSMsgType.TEXT:
                    return socket.close_code, answers
                answer = json.loads(received.data)
                if answer['type'] == 'answer':
                    answers.append(answer)
                if len(answers) == len(messages):
                    return None, answers

    return asyncio.run(talk())


@pytest.mark.long
def test_messages_are_bounded(here):
    """What is too large or comes too fast ends the connection; what is nonsense is answered."""
    assert closed(here, ['x' * 5000])[0] == aiohttp.WSCloseCode.MESSAGE_TOO_BIG
    assert closed(here, ['{}'] * 100)[0] == aiohttp.WSCloseCode.POLICY_VIOLATION
    nonsense = ['', '[', '[1]', '{"begin": "a"}', '{"begin": 1e99}', '{"begin": 7}', '[' * 4000]
    code, answers = closed(here, nonsense)
    assert code is None
    assert [answer['success'] for answer in answers] == [False] * len(nonsense)
    assert all(answer['text'] for answer in answers)


@pytest.mark.parametrize('host', ['', '0.0.0.0', '::'])
def test_the_url_of_a_server_on_all_addresses_has_the_name_of_the_machine(host):
    """A browser cannot open an address that stands for all; aiohttp takes '' for one."""
    policy = AccessPolicy(host, 8090)
    assert policy.url == f'http://{socket.gethostname()}:8090/?token={policy.token}'


def test_an_unknown_host_is_named(bag, capsys):
    """Exit code 2 and a sentence; .invalid never resolves (RFC 2606)."""
    assert main(['watch', bag, '--host', 'x.invalid', '--port', '0']) == 2
    said = capsys.readouterr().err
    assert said.startswith('satdyn watch: --host is x.invalid: ')
    assert said.count('\n') == 1
