"""Who may come in: no page of another site may fly the satellite, and no stranger on the net."""

import hmac
import ipaddress
import secrets
import socket
from urllib.parse import urlsplit

from aiohttp import web

_COOKIE_S = 30 * 86400


class Door:
    """
    The rule by which a server refuses requests.

    On a loopback host only those are taken that were sent to this machine by name (a foreign name
    that leads here is an attack by DNS).  On any other host there is a token in place of that: it
    is shown once, in the URL, and lives on as a cookie that other sites' pages cannot send.
    Everywhere a request from a page of another origin is refused.
    """

    def __init__(self, host: str, port: int):
        self._host, self.port = host, port
        self.token = None if is_loopback(host) else secrets.token_urlsafe(24)

    @property
    def url(self) -> str:
        """Return where the page is, with the token where there is one."""
        # Who listens everywhere is reached by the machine's name.
        host = socket.gethostname() if self._host in ('0.0.0.0', '::') else self._host
        host = f'[{host}]' if ':' in host else host
        query = f'?token={self.token}' if self.token else ''
        return f'http://{host}:{self.port}/{query}'

    @property
    def _cookie(self) -> str:
        # Cookies know no ports: two servers on one machine must not share a name.
        return f'satdyn_{self.port}'

    def refusal(self, request: web.Request) -> str | None:
        """Return why a request is refused, in one sentence, or None."""
        origin = request.headers.get('Origin')
        if origin is not None and origin != f'http://{request.host}':
            return 'a page from another origin may not use this server'
        if self.token is None:
            if _name_of(request.host) not in ('127.0.0.1', '::1', 'localhost'):
                return 'on loopback the server answers only to 127.0.0.1, [::1] and localhost'
            return None
        given = request.cookies.get(self._cookie, '') or request.query.get('token', '')
        if not hmac.compare_digest(given.encode(), self.token.encode()):
            return 'a token is needed: open the URL that satdyn watch printed'
        return None

    def let_in(self, request: web.Request, response: web.Response) -> None:
        """Leave the token as a cookie with who brought it in the URL."""
        if self.token is not None and request.query.get('token'):
            response.set_cookie(
                self._cookie,
                self.token,
                max_age=_COOKIE_S,
                httponly=True,
                samesite='Strict',
                path='/',
            )


def is_loopback(host: str) -> bool:
    """Return whether a host is this machine alone."""
    if host == 'localhost':
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _name_of(host):
    """Return the name in a Host header, without port."""
    try:
        return urlsplit(f'//{host}').hostname
    except ValueError:
        return None
