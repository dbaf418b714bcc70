#!/usr/bin/env python3
"""Opens a report in headless Chromium and uses it: report.py REPORT.html FOLDER_FOR_SCREENSHOTS [1280-light ...].

At 1280 and 390 pixels, light and dark, or as asked: no console error, nothing is loaded, nothing overflows, charts answer to pointer,
tap and keys, the switch switches, the legend hides, the wipe follows drag and keys, tables sort, and text can be read.
Prints what failed and ends with 1. The report is that of `leaves_a_report` in host/cli/tests/measure/report.rs.
"""

import shutil
import sys
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

WIDTHS = (1280, 390)
SCHEMES = ("light", "dark")
# A finger's width by Apple and Google is 44 to 48 px, by WCAG 2.2 at least 24; what is in rows here has 36.
SMALLEST_TARGET_PX = 36
# WCAG AA for text of this size.
MIN_CONTRAST = 4.5

failures = []


def check(holds, what):
    """Notes a failure and goes on: one run names all of them."""
    if not holds:
        failures.append(what)
        print(f"FAILED: {what}", file=sys.stderr)


def centre(locator):
    box = locator.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def tip(page):
    return page.locator("#tip")


def first_line(mark):
    return mark.get_attribute("data-tip").split("\n")[0]


def check_layout(page: Page, name):
    for target in ("document.documentElement", "document.body"):
        wide = page.evaluate(f"{target}.scrollWidth")
        width = page.evaluate("document.documentElement.clientWidth")
        check(wide <= width, f"{name}: {target} is {wide} px wide in a window of {width}")
    small = page.evaluate(
        """least => [...document.querySelectorAll('button, select, summary, nav a')]
            .filter(node => node.checkVisibility() && node.getBoundingClientRect().height < least)
            .map(node => node.textContent.trim())""",
        SMALLEST_TARGET_PX,
    )
    check(not small, f"{name}: too small to be tapped: {small}")


CONTRASTS = """() => {
  const channel = v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const parse = text => text.match(/[\\d.]+/g).map(Number);
  const luminance = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
  const behind = node => {
    for (; node; node = node.parentElement) {
      const color = parse(getComputedStyle(node).backgroundColor);
      if (color.length < 4 || color[3] > 0.99) return color;
    }
    return [255, 255, 255];
  };
  const worst = {};
  for (const selector of ['p', 'h2', 'td', 'th', '.dim', '.note', 'code', '.legend span', '.verdict', '.chart text', 'nav a', 'dt']) {
    for (const node of document.querySelectorAll(selector)) {
      if (!node.checkVisibility()) continue;
      const style = getComputedStyle(node);
      const ink = luminance(parse(node.tagName === 'text' ? style.fill : style.color));
      const paper = luminance(behind(node));
      const contrast = (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05);
      worst[selector] = Math.min(worst[selector] ?? 99, contrast);
    }
  }
  return worst;
}"""


def check_colours(page, scheme, name):
    for selector, contrast in page.evaluate(CONTRASTS).items():
        check(contrast >= MIN_CONTRAST, f"{name}: contrast of {selector} is {contrast:.2f}")
    red = page.evaluate("Number(getComputedStyle(document.body).backgroundColor.match(/\\d+/)[0])")
    check((red > 200) == (scheme == "light"), f"{name}: the page is not {scheme}")


def check_marks(page, is_touch, name, folder):
    chart = page.locator("[data-chart=flip] .chart").locator("visible=true").first
    chart.scroll_into_view_if_needed()
    marks = chart.locator(".point")
    count = marks.count()
    check(count > 30, f"{name}: {count} marks")
    check(tip(page).is_hidden(), f"{name}: the tip is there before a mark is pointed at")
    for index in (0, count // 2, count - 1):
        mark = marks.nth(index)
        x, y = centre(mark)
        page.touchscreen.tap(x, y) if is_touch else page.mouse.move(x, y)
        if tip(page).is_hidden():
            check(False, f"{name}: no tip at mark {index}")
            continue
        text = tip(page).inner_text()
        check(first_line(mark) in text, f"{name}: mark {index} is {first_line(mark)}, the tip says {text}")
        check("FLIP" in text and "ms" in text, f"{name}: the tip has no numbers: {text}")
        box = tip(page).bounding_box()
        inside = box["x"] >= 0 and box["x"] + box["width"] <= page.viewport_size["width"]
        check(inside, f"{name}: the tip leaves the window: {box}")
    page.screenshot(path=folder / f"{name}-tip.png")
    if not is_touch:
        page.mouse.move(2, 2)
        check(tip(page).is_hidden(), f"{name}: the tip stays when the pointer leaves")
    # Keys: one stop of the tab key, then arrows.
    stops = chart.locator(".point[tabindex='0']")
    check(stops.count() == 1, f"{name}: {stops.count()} marks are stops of the tab key")
    page.locator("[data-show=flip]").first.focus()
    for _ in range(8):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.classList.contains('point')"):
            break
    check(page.evaluate("document.activeElement.classList.contains('point')"), f"{name}: no mark can be reached by tab")
    before = tip(page).inner_text()
    page.keyboard.press("ArrowRight")
    after = tip(page).inner_text()
    check(tip(page).is_visible() and before and after != before, f"{name}: arrows do not move: {before} {after}")
    page.keyboard.press("Escape")
    check(tip(page).is_hidden(), f"{name}: Escape leaves the tip")


def check_switch(page, name):
    panel = page.locator("[data-charts]").first
    for measure in ("relmse", "flip-caustics", "flip"):
        panel.locator(f"[data-show={measure}]").click()
        shown = panel.locator("[data-chart]").locator("visible=true")
        seen = [shown.nth(i).get_attribute("data-chart") for i in range(shown.count())]
        check(seen == [measure], f"{name}: {measure} was asked for, {seen} is shown")
        pressed = panel.locator("[data-show][aria-pressed=true]")
        check(pressed.count() == 1 and pressed.get_attribute("data-show") == measure, f"{name}: the pressed button is wrong")
    chart = panel.locator("[data-chart=flip] .chart").locator("visible=true").first
    before = chart.locator(".point:visible").count()
    button = panel.locator("[data-toggle]").first
    button.click()
    hidden = chart.locator(f".point[data-series='{button.get_attribute('data-toggle')}']").count()
    after = chart.locator(".point:visible").count()
    check(hidden > 0 and after == before - hidden, f"{name}: the legend hides {before - after} of {hidden} marks")
    button.click()
    check(chart.locator(".point:visible").count() == before, f"{name}: the legend does not bring marks back")


def check_wipe(page, name, folder):
    box = page.locator(".wipe-box").first
    wipe, handle = box.locator(".wipe"), box.locator(".handle")
    wipe.scroll_into_view_if_needed()
    value = lambda: int(handle.get_attribute("aria-valuenow"))
    shot = lambda: wipe.screenshot()
    check(value() == 50, f"{name}: the wipe starts at {value()}")
    start = shot()
    frame = wipe.bounding_box()
    y = frame["y"] + 0.5 * frame["height"]
    page.mouse.move(frame["x"] + 0.5 * frame["width"], y)
    page.mouse.down()
    page.mouse.move(frame["x"] + 0.4 * frame["width"], y, steps=3)
    page.mouse.move(frame["x"] + 0.2 * frame["width"], y, steps=3)
    page.mouse.up()
    check(abs(value() - 20) <= 1, f"{name}: dragged to 20, the wipe is at {value()}")
    place = handle.bounding_box()
    check(abs(place["x"] + place["width"] / 2 - frame["x"] - 0.2 * frame["width"]) < 3, f"{name}: the handle is elsewhere")
    check(shot() != start, f"{name}: the picture is the same after the drag")
    page.mouse.move(frame["x"] + 0.7 * frame["width"], y)
    check(abs(value() - 20) <= 1, f"{name}: the wipe follows a pointer that is not pressed")
    at = value()
    for key, expected in (("ArrowRight", at + 2), ("ArrowLeft", at), ("Home", 0), ("End", 100), ("Shift+ArrowLeft", 90)):
        handle.press(key)
        check(value() == expected, f"{name}: {key} moves the wipe to {value()}, not {expected}")
    used = box.locator("[data-part=cell]")
    before, first = used.get_attribute("href"), shot()
    options = box.locator("option")
    check(options.count() > 3, f"{name}: {options.count()} pictures to choose from")
    box.locator("select").select_option(index=options.count() - 1)
    check(used.get_attribute("href") != before and shot() != first, f"{name}: another picture was chosen, none came")
    handle.press("Home")
    for _ in range(5):
        handle.press("Shift+ArrowRight")
    page.screenshot(path=folder / f"{name}-wipe.png")


def check_sorting(page, name):
    table = page.locator("table[data-sortable]").first
    heads = table.locator("th")
    column = next(i for i in range(heads.count()) if heads.nth(i).inner_text().startswith("time"))
    for direction in ("ascending", "descending"):
        heads.nth(column).locator("button").click()
        check(heads.nth(column).get_attribute("aria-sort") == direction, f"{name}: the head does not say {direction}")
        values = table.evaluate(
            "(table, i) => [...table.tBodies[0].rows].map(row => row.cells[i].dataset.value).filter(Boolean).map(Number)", column
        )
        wanted = sorted(values, reverse=direction == "descending")
        check(len(values) > 2 and values == wanted, f"{name}: not {direction}: {values}")


def check_page(browser, path, width, scheme, folder):
    name = f"{width}-{scheme}"
    is_touch = width < 600
    context = browser.new_context(viewport={"width": width, "height": 844}, color_scheme=scheme, has_touch=is_touch)
    page = context.new_page()
    page.on("console", lambda message: check(message.type not in ("error", "warning"), f"{name}: console: {message.text}"))
    page.on("pageerror", lambda error: check(False, f"{name}: {error}"))
    foreign = lambda url: not url.startswith("data:") and url != path.as_uri()
    page.on("request", lambda request: check(not foreign(request.url), f"{name}: asks for {request.url}"))
    page.goto(path.as_uri())
    check_layout(page, name)
    check_colours(page, scheme, name)
    page.screenshot(path=folder / f"{name}.png", full_page=True)
    check_marks(page, is_touch, name, folder)
    check_switch(page, name)
    check_wipe(page, name, folder)
    check_sorting(page, name)
    check_layout(page, f"{name}, used")
    context.close()


def main():
    path, folder, asked = Path(sys.argv[1]).resolve(), Path(sys.argv[2]), sys.argv[3:]
    pages = [(width, scheme) for width in WIDTHS for scheme in SCHEMES if not asked or f"{width}-{scheme}" in asked]
    folder.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        # Chromium has no sandbox for root, as which containers run.
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        check(pages, f"no page is called {asked}")
        for width, scheme in pages:
            try:
                check_page(browser, path, width, scheme, folder)
            except Exception as error:  # What is not there fails its check, and the other pages are still looked at.
                check(False, f"{width}-{scheme}: {error}")
        browser.close()
    print(f"{path.name}: {len(failures)} failures; screenshots in {folder}")
    sys.exit(1 if failures else 0)


main()
