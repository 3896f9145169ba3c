"""The page's server by its own test client: who may ask, what it answers, what reaches the board."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Iterator

import pytest
from fastapi.testclient import TestClient

from gen.live.access import OWN_HEADER
from gen.live.server import Live, make_app
from tests.live.serving import HEADER, TOKEN, FedSource

PORT = 8765
BASE = f"http://127.0.0.1:{PORT}"
OWN = {OWN_HEADER: "1"}


@pytest.fixture
def source() -> FedSource:
    return FedSource()


@pytest.fixture
def stranger(source: FedSource) -> Iterator[TestClient]:
    app = make_app([Live(source)], TOKEN, frozenset([f"127.0.0.1:{PORT}", f"localhost:{PORT}"]), PORT)
    with TestClient(app, base_url=BASE, follow_redirects=False) as client:
        yield client


@pytest.fixture
def client(stranger: TestClient) -> TestClient:
    assert stranger.get(f"/?token={TOKEN}").status_code == 303
    return stranger


PATHS = ["/", "/live.js", "/plotly.js", "/about", "/1/history", "/1/events", "/1/run.csv", "/2/history", "/nothing"]


@pytest.mark.parametrize("path", PATHS)
def test_nothing_is_told_without_the_token(stranger: TestClient, path: str) -> None:
    for given in (path, f"{path}?token=wrong"):
        answer = stranger.get(given)
        assert answer.status_code == 403
        assert "set-cookie" not in answer.headers


def test_the_token_opens_the_page_and_leaves_the_address(stranger: TestClient) -> None:
    answer = stranger.get(f"/?token={TOKEN}")
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    page = stranger.get("/")
    assert page.status_code == 200
    assert TOKEN not in page.text
    policy = page.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self';" in policy


def test_a_page_that_asks_for_hardly_any_points_still_gets_sixty_four(client: TestClient, source: FedSource) -> None:
    """What thins a curve needs so many; a run of no more rows comes whole."""
    rows = "".join(f"{i},5,{30 + i % 7},30,0,0,0\n" for i in range(64))
    source.view.feed(HEADER + rows.encode(), 0.0)
    times, _ = client.get("/1/history?most=1").json()["curves"]["coil_degC"]
    assert times == [float(i) for i in range(64)]


def test_another_name_that_leads_here_is_refused(client: TestClient) -> None:
    assert client.get("/about", headers={"host": f"localhost:{PORT}"}).status_code == 200
    for host in ("evil.example", f"evil.example:{PORT}", "127.0.0.1:1"):
        assert client.get("/about", headers={"host": host}).status_code == 421


def test_another_site_s_script_cannot_act(client: TestClient, source: FedSource) -> None:
    """It could send a form with the cookie, but not the header."""
    assert client.post("/1/arm", json={"armed": True}).status_code == 403
    assert client.post("/1/arm", json={"armed": True}, headers=OWN).status_code == 200
    assert client.post("/1/pwm", json={"count": 10}).status_code == 403
    assert source.told.sent == []


def test_commands_go_to_the_board_only_while_armed(client: TestClient, source: FedSource) -> None:
    answer = client.post("/1/pwm", json={"count": 90}, headers=OWN)
    assert (answer.status_code, answer.json()) == (409, {"error": "not armed: nothing was sent"})
    assert client.post("/1/arm", json={"armed": True}, headers=OWN).json()["armed_s"] > 0
    assert client.post("/1/pwm", json={"count": 90}, headers=OWN).status_code == 200
    assert client.post("/1/line", json={"text": "rows 4"}, headers=OWN).status_code == 200
    assert client.post("/1/arm", json={"armed": False}, headers=OWN).json()["armed_s"] == 0
    assert client.post("/1/line", json={"text": "reset"}, headers=OWN).status_code == 409
    assert source.told.sent == [b"arm\n90\n", b"rows 4\n"]


@pytest.mark.parametrize(
    ("path", "body", "status"),
    [
        ("/1/pwm", {"count": 300}, 422),
        ("/1/pwm", {"count": "x"}, 422),
        ("/1/pwm", {}, 422),
        ("/1/line", {"text": "format c:"}, 422),
        ("/1/change", {"name": "room", "value": 90.0}, 422),
        ("/1/change", {"name": "room", "value": "warm"}, 422),
        ("/1/change", {"name": "kind", "value": "c"}, 422),
        ("/1/change", {"name": "pull", "value": 1.5}, 422),
        ("/1/change", {"name": "pull", "value": 1}, 200),
        ("/1/change", {"name": "other", "value": 1.0}, 422),
        ("/1/change", {"name": "room", "value": 25}, 200),
        ("/1/change", {"name": "kind", "value": "b"}, 200),
    ],
)
def test_what_the_page_asks_for_is_checked(
    client: TestClient, source: FedSource, path: str, body: dict[str, object], status: int
) -> None:
    client.post("/1/arm", json={"armed": True}, headers=OWN)
    assert client.post(path, json=body, headers=OWN).status_code == status
    assert source.told.sent == []
    assert source.told.changed == ([(body["name"], body["value"])] if status == 200 else [])


def test_each_of_two_motors_is_armed_and_told_for_itself() -> None:
    sources = [FedSource(), FedSource()]
    app = make_app([Live(source) for source in sources], TOKEN, frozenset([f"127.0.0.1:{PORT}"]), PORT)
    with TestClient(app, base_url=BASE) as client:
        assert client.get("/2/history").status_code == 403
        client.get(f"/?token={TOKEN}")
        assert len(client.get("/about").json()["motors"]) == 2
        assert client.post("/2/arm", json={"armed": True}, headers=OWN).json()["armed_s"] > 0
        assert client.post("/1/pwm", json={"count": 90}, headers=OWN).status_code == 409
        assert client.post("/2/pwm", json={"count": 90}, headers=OWN).status_code == 200
        assert client.post("/2/pwm", json={"count": 91}).status_code == 403
        client.post("/1/change", json={"name": "kind", "value": "b"}, headers=OWN)
        sources[1].view.feed(HEADER + b"0,5,30,30,0,0,0\n", 0.0)
        assert client.get("/2/run.csv").text.endswith("0,5,30,30,0,0,0\n")
        assert 'filename="run-2.csv"' in client.get("/2/run.csv").headers["content-disposition"]
        assert client.get("/1/run.csv").text == ""
        assert client.get("/3/history").status_code == 404
    assert [source.told.sent for source in sources] == [[], [b"arm\n90\n"]]
    assert [source.told.changed for source in sources] == [[("kind", "b")], []]


def test_a_run_file_of_what_came_so_far(client: TestClient, source: FedSource) -> None:
    source.view.feed(b"# model: m\n" + HEADER + b"0,5,30,30,0,0,0\nbad\n", 0.0)
    lines = client.get("/1/run.csv").text.splitlines()
    assert lines[0] == "# model: m"
    assert lines[-2:] == [HEADER.decode().strip(), "0,5,30,30,0,0,0"]


def test_events_go_on_after_the_last_row_that_came(source: FedSource) -> None:
    source.view.feed(HEADER + b"".join(b"%d,5,30,30,0,0,0\n" % k for k in range(10)), 0.0)
    live = Live(source)

    async def first(part: int, row: int) -> tuple[str, dict[str, object]]:
        async def here() -> bool:
            return False

        stream = live.events(part, row, here)
        try:
            event = await anext(stream)
        finally:
            await stream.aclose()  # type: ignore[attr-defined]
        number, data = event.strip().split("\n")
        return number, json.loads(data.removeprefix("data: "))

    number, told = asyncio.run(first(1, 7))
    assert number == "id: 1.10"
    assert [row[0] for row in told["rows"]] == [7.0, 8.0, 9.0]  # type: ignore[attr-defined]
    _, told = asyncio.run(first(0, 7))  # of a part that is gone: from the beginning
    assert len(told["rows"]) == 10  # type: ignore[arg-type]


def test_everything_that_the_page_loads_is_here(client: TestClient) -> None:
    page = client.get("/").text
    assert "http" not in page.replace("http-equiv", "")
    for path, kind in (
        ("/live.js", "text/javascript"),
        ("/motor.js", "text/javascript"),
        ("/live.css", "text/css"),
        ("/plotly.js", "text/javascript"),
    ):
        answer = client.get(path)
        assert answer.status_code == 200
        assert answer.headers["content-type"].startswith(kind)
    for name in re.findall(r'src="(\w+\.js)"', page):
        answer = client.get(f"/{name}")
        assert answer.status_code == 200
        assert name == "plotly.js" or "innerHTML" not in answer.text
