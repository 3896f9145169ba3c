"""The page in a real browser: headless Chromium, driven by Playwright."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, Locator, Page, Route, expect, sync_playwright

from gen.coefficients import Coefficients, load
from gen.coefficients.alarms import MissingHeat
from gen.live.heat import HeatFromRows
from gen.live.known import Known, known_of
from tests.live.serving import HEADER, FedSource, served, wait_until
from tests.live.test_sources import EXAMPLE, FAULT, emulated, quick

__all__ = ["quick"]  # the fixture

CHROMIUM = shutil.which("chromium")
"""Debian's, which `scripts/setup.sh test` installs; without it these tests fail."""
QUIET = ["gpu", "quic", "background-networking", "component-update", "sync"]
SLOW_MS = 30_000


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    assert CHROMIUM is not None, "needs Debian's chromium: scripts/setup.sh test installs it"
    with sync_playwright() as play:
        options = ["--no-sandbox", "--no-first-run", *(f"--disable-{what}" for what in QUIET)]
        browser = play.chromium.launch(executable_path=CHROMIUM, args=options)
        yield browser
        browser.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """A new page; whatever it complains of, and every address that it asks, is looked at in the end."""
    page = browser.new_page()
    page.set_default_timeout(SLOW_MS)
    expect.set_options(timeout=SLOW_MS)
    wrong: list[str] = []
    hosts: set[str | None] = set()
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda said: wrong.append(said.text) if "Content Security Policy" in said.text else None)
    page.on("request", lambda asked: hosts.add(urlsplit(asked.url).hostname))
    yield page
    page.close()
    assert wrong == []
    assert hosts <= {"127.0.0.1", None}


def row(k: int, alarms: int = 0, sensor: int = 0) -> bytes:
    return b"%d,%d,%.2f,30,0,%d,%d\n" % (k, k % 200, 30 + k / 10, sensor, alarms)


def right_end(page: Page) -> float:
    """The largest time that the drawing shows, from its own axis."""
    return float(page.evaluate("document.getElementById('plot')._fullLayout.xaxis.range[1]"))


def test_curves_and_table_move_with_the_rows(page: Page) -> None:
    source = FedSource(Known(("coil_hot",), ("coil",), {"coil": ((0, 255, -1.0, 1.0),)}))
    source.view.feed(HEADER + b"".join(map(row, range(10))), 0.0)
    with served(source) as address:
        page.goto(address)
        expect(page.locator("#drive")).to_contain_text("time 9.0 s, PWM 9")
        expect(page.locator("#plot")).to_have_attribute("data-points", "10")
        assert right_end(page) == 9.0
        traces = page.locator("#plot .scatterlayer .trace")
        before = traces.evaluate_all("all => all.map(one => one.querySelector('path.js-line')?.getAttribute('d'))")
        source.view.feed(b"".join(map(row, range(10, 60))), 1.0)
        expect(page.locator("#drive")).to_contain_text("time 59.0 s, PWM 59")
        expect(page.locator("#plot")).to_have_attribute("data-points", "60")
        assert right_end(page) == 59.0
        after = traces.evaluate_all("all => all.map(one => one.querySelector('path.js-line')?.getAttribute('d'))")
        assert len(before) == len(after) >= 3
        assert before != after
        cells = page.locator("#now tr").first.locator("th, td")
        expect(cells).to_have_text(["coil", "35.90", "30.00", "5.90", "29.0 to 31.0", "ok"])
        assert "bad" in (cells.nth(3).get_attribute("class") or "")
        expect(page.locator("#rows")).to_have_text("60")


def test_an_alarm_and_a_broken_sensor_are_seen_and_go(page: Page) -> None:
    source = FedSource()
    source.view.feed(HEADER + row(0), 0.0)
    with served(source) as address:
        page.goto(address)
        expect(page.locator("#rows")).to_have_text("1")
        expect(page.locator("#alarms")).to_be_empty()
        source.view.feed(row(1, alarms=1, sensor=1), 1.0)
        expect(page.locator("#alarms")).to_have_text("Alarm: coil_hot")
        expect(page.locator("#signals")).to_contain_text(
            "LED: 1 blink, a pause: alarm coil_hot; flicker: a thermocouple is not believed. Relay: closed"
        )
        expect(page.locator("#now tr").first.locator("td").last).to_have_text("open")
        source.view.feed(row(2), 2.0)
        expect(page.locator("#alarms")).to_be_empty()


def panels(page: Page) -> set[str]:
    """Titles of the drawing's vertical axes."""
    titles = "layout => Object.keys(layout).filter(key => key.startsWith('yaxis')).map(key => layout[key].title.text)"
    return set(page.evaluate(f"({titles})(document.getElementById('plot')._fullLayout)"))


def test_missing_heat_and_time_to_a_limit_have_values_and_curves(page: Page) -> None:
    example = load(EXAMPLE)
    source = FedSource(known_of(example), HeatFromRows(example))
    limits = {rule.name: rule.threshold_K for rule in example.document.alarms if isinstance(rule, MissingHeat)}
    heat, brush, bearing = (f"{limits[name]:g}" for name in ("heat", "brush_fault", "bearing_fault"))
    parts = ("brush", "bearing", "magnet", "casing")
    names = [*(f"{name}_degC" for name in parts), *(f"{name}_model_degC" for name in parts), "ambient_degC"]
    header = ",".join(["time_s", "pwm", *names, "flags", "time_to_limit_s", "holdable_pwm"])

    def rows(first: int, last: int) -> bytes:
        told = "{0},153,{1},{1},{1},{1},30,30,30,30,30,0,{2},200\n"
        return "".join(told.format(k, 30 + k / 200, 900 - k if k > 50 else "") for k in range(first, last)).encode()

    source.view.feed(f"{header}\n".encode() + rows(0, 40), 0.0)
    with served(source) as address:
        page.goto(address)
        expect(page.locator("#heat")).to_have_text(
            "Missing heat (computed here from the rows): "
            f"heat 0 % of {heat} K, brush_fault 0 % of {brush} K, bearing_fault 0 % of {bearing} K"
        )
        expect(page.locator("#plot")).to_have_attribute("data-panels", "3")
        assert panels(page) == {"°C", "PWM", "heat, %"}
        source.view.feed(rows(40, 900), 1.0)
        expect(page.locator("#heat")).to_contain_text(f"heat 200 % of {heat} K")
        expect(page.locator("#drive")).to_contain_text("no limit for 1 s at this PWM, PWM 200 can be held")
        expect(page.locator("#plot")).to_have_attribute("data-panels", "4")
        assert panels(page) == {"°C", "PWM", "heat, %", "limit, s"}


def test_a_hostile_row_stays_text(page: Page) -> None:
    source = FedSource()
    with served(source) as address:
        page.goto(address)
        hostile = b"<img src=x onerror=\"document.title='owned'\"><script>document.title='owned'</script>"
        source.view.feed(HEADER + row(0) + hostile + b"\n# event: 1 " + hostile + b"\n" + row(1), 0.0)
        expect(page.locator("#garbled")).to_have_text("1")
        expect(page.locator("#lines")).to_contain_text(hostile.decode())
        assert page.locator("#lines *").count() == 0
        assert page.locator("img").count() == 0
        expect(page).to_have_title("bench: gen live")


def test_commands_wait_for_the_page_to_be_armed(page: Page) -> None:
    """By keyboard alone."""
    source = FedSource()
    source.view.feed(HEADER + row(0), 0.0)
    with served(source) as address:
        page.goto(address)
        expect(page.locator("#halt")).to_be_disabled()
        expect(page.locator("#armed")).to_have_text("not armed: nothing is sent")
        page.locator("#arm").focus()
        page.keyboard.press("Enter")
        expect(page.locator("#board")).to_have_class("board armed")
        page.keyboard.press("Tab")
        page.keyboard.press("Control+A")
        page.keyboard.type("90")
        page.keyboard.press("Enter")
        wait_until(lambda: source.told.sent == [b"arm\n90\n"])
        page.locator("#line").fill("format c:")
        page.keyboard.press("Enter")
        expect(page.locator("#refused")).to_contain_text("expected a PWM")
        page.locator("#arm").click()
        expect(page.locator("#halt")).to_be_disabled()
    assert source.told.sent == [b"arm\n90\n"]


def test_what_was_looked_up_before_a_command_does_not_take_it_back(page: Page) -> None:
    """An event of the stream that was on its way while the board was armed arrives behind the answer that says so."""
    source = FedSource()
    source.view.feed(HEADER + row(0), 0.0)
    with served(source) as address:
        page.goto(address)
        expect(page.locator("#rows")).to_have_text("1")
        before = page.request.get(f"{address.partition('?')[0]}1/history").json()["status"]
        page.locator("#arm").click()
        expect(page.locator("#board")).to_have_class("board armed")
        page.evaluate("status => motors[0].showStatus(status)", before)
        assert page.locator("#board").get_attribute("class") == "board armed"
        assert page.locator("#halt").is_enabled()


def test_what_is_asked_arrives_in_the_order_asked(page: Page) -> None:
    """A stop waits for the answer to the command that it stops: it must not overtake it on the way."""
    source = FedSource()
    source.view.feed(HEADER + row(0), 0.0)
    held: list[Route] = []
    with served(source) as address:
        page.goto(address)
        expect(page.locator("#rows")).to_have_text("1")  # what comes first moves the button
        page.locator("#arm").click()
        expect(page.locator("#board")).to_have_class("board armed")
        page.route("**/1/pwm", lambda route: held.append(route), times=1)
        page.locator("#pwm").fill("90")
        page.keyboard.press("Enter")
        page.locator("#halt").click()
        page.locator("#line").fill("format c:")
        page.keyboard.press("Enter")
        page.evaluate("() => new Promise((done) => setTimeout(done, 300))")
        assert len(held) == 1
        assert source.told.sent == []
        held[0].continue_()
        expect(page.locator("#refused")).to_contain_text("expected a PWM")
    assert source.told.sent == [b"arm\n90\n", b"0\n"]


def test_a_stop_counts_when_it_is_pressed_whatever_moves_then(page: Page) -> None:
    """An alarm appears above the button while it is held down: what is let go elsewhere is no click."""
    source = FedSource()
    source.view.feed(HEADER + row(0), 0.0)
    with served(source) as address:
        page.set_viewport_size({"width": 1280, "height": 1600})  # all of it: where a page scrolls, browsers hold it
        page.goto(address)
        expect(page.locator("#rows")).to_have_text("1")
        page.locator("#arm").click()
        expect(page.locator("#board")).to_have_class("board armed")
        stop = page.locator("#halt")
        before = _middle(stop)
        page.mouse.move(*before)
        page.mouse.down()
        source.view.feed(row(1, alarms=1), 1.0)
        expect(page.locator("#alarms")).to_have_text("Alarm: coil_hot")
        assert _middle(stop)[1] > before[1] + 20.0
        page.mouse.up()
        wait_until(lambda: source.told.sent == [b"0\n"])
        stop.click()
        wait_until(lambda: source.told.sent == [b"0\n"] * 2)
        stop.focus()
        page.keyboard.press("Enter")
        wait_until(lambda: source.told.sent == [b"0\n"] * 3)
        page.mouse.move(*_middle(stop))
        page.mouse.down(button="right")
        page.mouse.up(button="right")
        page.locator("#line").fill("?")
        page.keyboard.press("Enter")
        wait_until(lambda: source.told.sent == [*[b"0\n"] * 3, b"?\n"])


def _middle(button: Locator) -> tuple[float, float]:
    """Where it is in the window."""
    button.scroll_into_view_if_needed()
    box = button.bounding_box()
    assert box is not None
    return box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]


def test_a_command_without_an_answer_holds_up_none_after_it(page: Page) -> None:
    source = FedSource()
    source.view.feed(HEADER + row(0), 0.0)
    with served(source) as address:
        page.goto(address)
        expect(page.locator("#rows")).to_have_text("1")  # what comes first moves the button
        page.locator("#arm").click()
        expect(page.locator("#board")).to_have_class("board armed")
        page.route("**/1/pwm", lambda route: route.abort(), times=1)
        page.locator("#pwm").fill("90")
        page.keyboard.press("Enter")
        expect(page.locator("#refused")).to_contain_text("did not answer")
        page.locator("#halt").click()
        expect(page.locator("#refused")).to_be_empty()
    assert source.told.sent == [b"0\n"]


def test_what_the_page_changes_reaches_the_source(page: Page) -> None:
    source = FedSource()
    with served(source) as address:
        page.goto(address)
        page.get_by_label("kind").select_option("b")
        page.get_by_label("room").fill("25.5")
        page.keyboard.press("Enter")
        wait_until(lambda: source.told.changed == [("kind", "b"), ("room", 25.5)])
        page.get_by_label("pull").focus()
        page.keyboard.press("ArrowRight")
        expect(page.locator("output")).to_have_text("0.05")
        wait_until(lambda: source.told.changed[2:] == [("pull", 0.05)])


def test_it_goes_on_when_the_server_was_away(page: Page) -> None:
    source = FedSource()
    source.view.feed(HEADER + row(0), 0.0)
    with served(source) as address:
        port = int(re.findall(r":(\d+)/", address)[0])
        page.goto(address)
        expect(page.locator("#rows")).to_have_text("1")
    expect(page.locator("#link")).to_contain_text("trying again")
    again = FedSource()
    again.view.feed(HEADER + row(0) + row(1) + row(2), 0.0)
    with served(again, port=port):
        expect(page.locator("#rows")).to_have_text("3")
        expect(page.locator("#plot")).to_have_attribute("data-points", "3")


def test_hours_of_rows_are_never_more_than_some_thousand_points(page: Page) -> None:
    """Three hours at 4 Hz are there when the page opens; half an hour more comes while it is open."""
    source = FedSource()
    source.view.feed(HEADER + b"".join(row(k) for k in range(43_200)), 0.0)
    with served(source) as address:
        page.goto(address)
        expect(page.locator("#drive")).to_contain_text("time 43199.0 s")
        expect(page.locator("#plot")).to_have_attribute("data-points", re.compile(r"1\d{3}|2000"))
        source.view.feed(b"".join(row(k) for k in range(43_200, 50_400)), 1.0)
        expect(page.locator("#drive")).to_contain_text("time 50399.0 s")
        expect(page.locator("#plot")).to_have_attribute("data-until", "50399")
        expect(page.locator("#plot")).to_have_attribute("data-points", re.compile(r"1\d{3}|2000"))
        assert right_end(page) == 50_399.0


def test_a_phone_shows_all_of_it(browser: Browser) -> None:
    source = FedSource()
    source.view.feed(HEADER + row(0), 0.0)
    page = browser.new_page(viewport={"width": 360, "height": 740}, color_scheme="dark")
    with served(source) as address:
        page.goto(address)
        expect(page.locator("#rows")).to_have_text("1")
        assert page.evaluate("document.documentElement.scrollWidth") <= 360
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(21, 24, 28)"
    page.close()


def test_a_fault_switched_on_in_the_page_is_seen_by_the_emulated_board(
    page: Page, quick: Coefficients, tmp_path: Path
) -> None:
    source = emulated(quick, tmp_path)
    with served(source) as address:
        page.goto(address)
        expect(page.locator("#drive")).to_contain_text("PWM 0")
        page.locator("#arm").click()
        page.locator("#pwm").fill("200")
        page.locator("#pwm-form button[type=submit]").click()
        expect(page.locator("#drive")).to_contain_text("PWM 200")
        expect(page.locator("#alarms")).to_be_empty()
        page.get_by_label("fault of the motor").select_option(FAULT)
        expect(page.locator("#alarms")).to_have_text("Alarm: bearing_warm")
