"""What comes to the server and is no HTTP is answered, and the log stays silent."""

import socket
from urllib.parse import urlsplit

import pytest

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.run.scenario import Scenario

HEAD = b'GET / HTTP/1.1\r\nHost: localhost\r\n'


@pytest.fixture(scope='module')
def port(watch, tmp_path_factory):
    """Return the port of a server; at its end it has said nothing on stderr, see watch."""
    path = tmp_path_factory.mktemp('server') / 'bag'
    for _ in simulate(Scenario.from_dict({'time': {'epoch_ns': 10**18}}), 1, path):
        pass
    return urlsplit(watch(str(path))).port


def answer(port, data):
    """Return the first line of what the server says to bytes."""
    with socket.create_connection(('127.0.0.1', port), timeout=60) as connection:
        connection.sendall(data)
        return connection.makefile('rb').readline()


@pytest.mark.parametrize(
    'data',
    [
        b'\x00\x01\x02\xff\xfe\r\n\r\n',
        b'\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n',
        HEAD + b'X: ' + 20000 * b'a' + b'\r\n\r\n',
        b'GET /' + 20000 * b'a' + b' HTTP/1.1\r\nHost: localhost\r\n\r\n',
        HEAD.replace(b'GET', b'G@T') + b'\r\n',
        HEAD.replace(b'GET', b'FETCH') + b'\r\n',
        HEAD.replace(b'1.1', b'x.y') + b'\r\n',
        HEAD.replace(b'/ ', b'http://[::1/ ') + b'\r\n',
        HEAD + b'X\r\n\r\n',
        HEAD + b'X: a\0b\r\n\r\n',
        HEAD + b'Content-Length: many\r\n\r\n',
        HEAD + b'Transfer-Encoding: chunked\r\n\r\nzz\r\n',
    ],
    ids=[
        *('bytes', 'TLS', 'long header', 'long path', 'bad method', 'unknown method', 'version'),
        *('URL', 'no colon', 'zero byte', 'length', 'chunk'),
    ],
)
def test_what_is_no_http_is_a_bad_request(port, data):
    """RFC 9112, 2.2: a server answers what is no request with 400 (Bad Request)."""
    assert answer(port, data).split()[1] == b'400'


@pytest.mark.parametrize('header', ['Upgrade', 'Sec-WebSocket-Version', 'Sec-WebSocket-Key'])
def test_a_handshake_that_is_not_ascii_is_a_bad_request(port, header):
    """RFC 6455, 4.2.2: so is a handshake that does not match what it describes."""
    headers = {
        'Host': f'localhost:{port}',
        'Connection': 'Upgrade',
        'Upgrade': 'websocket',
        'Sec-WebSocket-Version': '13',
        'Sec-WebSocket-Key': 'dGhlIHNhbXBsZSBub25jZQ==',
    }
    headers[header] += 'é'
    lines = ['GET /socket HTTP/1.1', *(f'{name}: {value}' for name, value in headers.items())]
    data = '\r\n'.join([*lines, '', '']).encode('latin-1')
    assert answer(port, data).split()[1] == b'400'


def test_what_http_has_and_the_page_has_not(port):
    """RFC 9110, 15.5.6: a known method that a page does not have is not allowed, 405."""
    given = HEAD.replace(b'GET', b'POST').replace(b'localhost', b'localhost:%d' % port)
    body = b'Content-Encoding: gzip\r\nContent-Length: 3\r\n\r\nabc'
    assert answer(port, given + body).split()[1] == b'405'
