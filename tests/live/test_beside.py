"""Two motors on one page, in a real browser: side by side, each with its own alarms, commands and controls."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from gen.coefficients import Coefficients
from gen.live.pace import Pace
from tests.live.serving import HEADER, FedSource, served, wait_until
from tests.live.test_browser import browser, page, row
from tests.live.test_sources import FAULT, emulated, quick

__all__ = ["browser", "page", "quick"]  # the fixtures


@pytest.fixture
def pair() -> Iterator[tuple[FedSource, FedSource]]:
    first, second = FedSource(), FedSource()
    first.view.feed(HEADER + row(0) + row(1), 0.0)
    second.view.feed(HEADER + b"".join(map(row, range(100))), 0.0)
    yield first, second


def test_each_has_its_own_rows_alarms_and_commands(page: Page, pair: tuple[FedSource, FedSource]) -> None:
    first, second = pair
    with served(first, second) as address:
        page.goto(address)
        expect(page).to_have_title("bench beside bench: gen live")
        expect(page.locator("h1")).to_have_text(["Motor 1: bench (port)", "Motor 2: bench (port)"])
        expect(page.locator("#rows")).to_have_text("2")
        expect(page.locator("#rows-2")).to_have_text("100")
        second.view.feed(row(100, alarms=1), 1.0)
        expect(page.locator("#alarms-2")).to_have_text("Alarm: coil_hot")
        expect(page.locator("#alarms")).to_be_empty()
        page.locator("#arm-2").focus()
        page.keyboard.press("Enter")
        expect(page.locator("#board-2")).to_have_class("board armed")
        assert page.locator("#board").get_attribute("class") == "board"
        assert page.locator("#halt").is_disabled()
        page.keyboard.press("Tab")
        page.keyboard.press("Control+A")
        page.keyboard.type("90")
        page.keyboard.press("Enter")
        wait_until(lambda: second.told.sent == [b"arm\n90\n"])
        page.get_by_label("kind").nth(1).select_option("b")
        wait_until(lambda: second.told.changed == [("kind", "b")])
        assert page.locator("#file-2").get_attribute("href") == "2/run.csv"
    assert (first.told.sent, first.told.changed) == ([], [])


def test_what_was_looked_up_before_is_told_for_each_by_its_own_numbers(
    page: Page, pair: tuple[FedSource, FedSource]
) -> None:
    """The first motor's status, of a higher number than any of the second's, takes nothing back there."""
    with served(*pair) as address:
        page.goto(address)
        expect(page.locator("#rows-2")).to_have_text("100")
        before = page.request.get(f"{address.partition('?')[0]}2/history").json()["status"]
        page.locator("#arm-2").click()
        expect(page.locator("#board-2")).to_have_class("board armed")
        page.evaluate("status => motors[1].showStatus(status)", before)
        page.evaluate("status => motors[0].showStatus({...status, number: 1e6})", before)
        assert page.locator("#board-2").get_attribute("class") == "board armed"
        page.locator("#arm-2").click()
        expect(page.locator("#board-2")).to_have_class("board")


def test_the_curves_of_both_have_one_scale(page: Page, pair: tuple[FedSource, FedSource]) -> None:
    with served(*pair) as address:
        page.goto(address)
        expect(page.locator("#plot-2")).to_have_attribute("data-points", "100")
        expect(page.locator("#plot")).to_have_attribute("data-points", "2")
        ranges = "id => ['xaxis', 'yaxis'].map(axis => document.getElementById(id)._fullLayout[axis].range)"
        wait_until(lambda: page.evaluate(ranges, "plot") == page.evaluate(ranges, "plot-2"))
        x, y = page.evaluate(ranges, "plot")
        assert x == [0, 99]
        assert y[0] < 30.0 < 39.9 < y[1]
        page.get_by_role("button", name="5 min").click()
        assert page.evaluate(ranges, "plot")[0] == page.evaluate(ranges, "plot-2")[0] == [99 - 300, 99 + 9]


@pytest.mark.parametrize(("width", "beside"), [(1400, True), (360, False)])
def test_they_stand_side_by_side_where_there_is_room(
    browser: Browser, pair: tuple[FedSource, FedSource], width: int, beside: bool
) -> None:
    page = browser.new_page(viewport={"width": width, "height": 740})
    with served(*pair) as address:
        page.goto(address)
        expect(page.locator("#rows-2")).to_have_text("100")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        for name in ("#h-now", "#h-lines", "#name"):
            one, two = (page.locator(name + end).bounding_box() for end in ("", "-2"))
            assert one is not None
            assert two is not None
            assert (one["y"] == two["y"]) == beside
            assert (one["x"] < two["x"]) == beside
    page.close()


def test_a_fault_that_is_switched_on_in_one_raises_its_alarm_and_not_the_other_s(
    page: Page, quick: Coefficients, tmp_path: Path
) -> None:
    pace = Pace(1000.0)
    with served(emulated(quick, tmp_path, pace), emulated(quick, tmp_path, pace, leads=False)) as address:
        page.goto(address)
        for end in ("", "-2"):
            expect(page.locator(f"#drive{end}")).to_contain_text("PWM 0")  # what comes first moves the button
        for end in ("", "-2"):
            page.locator(f"#arm{end}").click()
            page.locator(f"#pwm{end}").fill("200")
            page.locator(f"#pwm-form{end} button[type=submit]").click()
            expect(page.locator(f"#drive{end}")).to_contain_text("PWM 200")
        page.locator("#control-fault-2").select_option(FAULT)
        expect(page.locator("#alarms-2")).to_have_text("Alarm: bearing_warm")
        expect(page.locator("#signals-2")).to_contain_text("LED: 1 blink, a pause: alarm bearing_warm")
        expect(page.locator("#alarms")).to_be_empty()
        expect(page.locator("#signals")).to_contain_text("LED: a short flash every 2 s: healthy")
