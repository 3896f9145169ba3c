"""Who may ask the page's server: a token, the host that was asked for, and no other site's scripts."""

from __future__ import annotations

import secrets
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

TOKEN = "token"
OWN_HEADER = "x-gen-live"
"""A script of another site cannot set it without asking first, and is refused then."""

_SAFE = ("GET", "HEAD")
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; connect-src 'self'; "
    "img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


def new_token() -> str:
    """A token that nobody guesses."""
    return secrets.token_urlsafe(24)


class Access:
    """Lets through what knows the token; the rest of the server is asked only then.

    Parameters
    ----------
    app
        The rest.
    token
        What the page's address holds; a cookie from its first visit on.
    hosts
        Names and ports under which the server is asked, as in ``Host``; others are a name of somebody else that leads
        here. None: any, where the server listens on more than this computer.
    port
        Cookies know no ports: two pages on one computer need two names.
    """

    def __init__(self, app: ASGIApp, token: str, hosts: frozenset[str] | None, port: int) -> None:
        self._app, self._token, self._hosts = app, token, hosts
        self._cookie = f"gen_live_{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or let the rest answer."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":
            return
        refusal = self._refusal(scope)
        if refusal is not None:
            await refusal(scope, receive, send)
            return

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [
                    *message["headers"],
                    (b"content-security-policy", _POLICY.encode()),
                    (b"x-content-type-options", b"nosniff"),
                    (b"referrer-policy", b"no-referrer"),
                    (b"cache-control", b"no-store"),
                ]
            await send(message)

        await self._app(scope, receive, guarded)

    def _refusal(self, scope: Scope) -> Response | None:
        headers = Headers(scope=scope)
        if self._hosts is not None and headers.get("host", "").lower() not in self._hosts:
            return PlainTextResponse("this is not the host that the page was made for\n", 421)
        given = parse_qs(scope["query_string"].decode("ascii", "replace")).get(TOKEN, [""])[0]
        if scope["method"] == "GET" and scope["path"] == "/" and self._is_token(given):
            answer = RedirectResponse("/", 303)  # so that the token is not left in the address
            answer.set_cookie(self._cookie, self._token, httponly=True, samesite="strict")
            return answer
        if not self._is_token(_cookie(headers.get("cookie", ""), self._cookie)):
            return PlainTextResponse("expected the address with its token, as gen live printed it\n", 403)
        if scope["method"] not in _SAFE and OWN_HEADER not in headers:
            return PlainTextResponse(f"expected the header {OWN_HEADER}\n", 403)
        return None

    def _is_token(self, text: str) -> bool:
        return secrets.compare_digest(text.encode(), self._token.encode())


def _cookie(header: str, name: str) -> str:
    try:
        found = SimpleCookie(header).get(name)
    except CookieError:
        return ""
    return "" if found is None else found.value
