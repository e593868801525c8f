"""Who is let in: no page of another site may control the satellite, nor may any stranger."""

import hmac
import ipaddress
import secrets
import socket
from urllib.parse import urlsplit

from aiohttp import web

_COOKIE_S = 30 * 86400


class AccessPolicy:
    """
    The rule by which a server refuses requests.

    On a loopback host it accepts only requests sent to this machine by one of its own names (a
    foreign name that resolves to it is a DNS attack).  On any other host a token takes the place
    of that: it is shown once, in the URL, and kept as a cookie that other sites' pages cannot
    send. Requests from a page of another origin are always refused.
    """

    def __init__(self, host: str, port: int):
        self._host, self.port = host, port
        self.token = None if is_loopback(host) else secrets.token_urlsafe(24)

    @property
    def url(self) -> str:
        """Return the URL of the page, with the token if there is one."""
        # A server that listens everywhere is reached by the machine's name.
        host = socket.gethostname() if self._host in ('', '0.0.0.0', '::') else self._host
        host = f'[{host}]' if ':' in host else host
        query = f'?token={self.token}' if self.token else ''
        return f'http://{host}:{self.port}/{query}'

    @property
    def _cookie(self) -> str:
        # Cookies ignore ports: two servers on one machine must not share a name.
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
        """Set the token as a cookie for a browser that sent it in the URL."""
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
