#!/usr/bin/env python3
"""Drives `caustics view` in headless Chromium: view.py CAUSTICS FOLDER_FOR_SCREENSHOTS [view's options].

At 1280 and 390 pixels, light and dark: no console error, pictures come, dragging orbits within the rate, every axis changes and
renders, the wipe follows, a pixel answers, PNG and EXR are saved and the copied command renders the same bits, onlookers look on,
the program ends by Ctrl-C. With CAUSTICS_REQUIRE_GPU also on a Vulkan device, whose kernels are exchanged. Prints what failed and ends
with 1.
"""

import hashlib
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parents[2]
SCENE = "mirror-room"
SIZE = (160, 90)
PATIENCE_S = 120
# What a finger hits; see tests/browser/report.py.
SMALLEST_TARGET_PX = 36

failures = []
# All that were started.
programs = []


def check(holds, what):
    """Notes a failure and goes on: one run names all of them."""
    if not holds:
        failures.append(what)
        print(f"FAILED: {what}", file=sys.stderr)


class Program:
    """The program, and the address that it printed."""

    def __init__(self, caustics, options, folder, scene=SCENE, token=None):
        width, height = SIZE
        command = [caustics, "view", scene, "--width", str(width), "--height", str(height), *options]
        if "--port" not in options:
            command += ["--port", "0"]
        environment = {**os.environ, "SOURCE_DATE_EPOCH": "0"}
        if token:
            environment["CAUSTICS_VIEW_TOKEN"] = token
        self.log = (folder / "program.log").open("w+")
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=self.log, env=environment)
        programs.append(self)
        self.address = None
        for _ in range(600):
            text = (folder / "program.log").read_text()
            found = re.search(r"http://\S+", text)
            if found:
                self.address = found[0]
                break
            if self.process.poll() is not None:
                raise SystemExit(f"the program ended: {text}")
            time.sleep(0.1)

    def kill(self):
        """For what failed; one that has ended is left alone."""
        self.process.kill()

    def end(self):
        self.process.send_signal(signal.SIGINT)
        try:
            code = self.process.wait(30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = "none"
        check(code == 0, f"Ctrl-C ends with {code}")


def until(page, expression, argument=None):
    """Waits until it holds in the page, whose policy lets no `wait_for_function` in."""
    end = time.monotonic() + PATIENCE_S
    while not page.evaluate(expression, argument):
        if time.monotonic() > end:
            raise TimeoutError(f"{expression} does not come to hold; {page.locator('body').inner_text()[:600]}")
        page.wait_for_timeout(50)


def watch(page, name):
    """Notes what the console says."""
    # What Chromium says of this script's own reading of pixels.
    mine = "getImageData"
    page.on("console", lambda line: check(mine in line.text or line.type not in ("error", "warning"), f"{name}: console: {line.text}"))
    page.on("pageerror", lambda error: check(False, f"{name}: {error}"))


def opened(context, address, name):
    page = context.new_page()
    page.set_default_timeout(1000 * PATIENCE_S)
    watch(page, name)
    page.goto(address)
    until(page, "document.body.dataset.serial")
    return page


def samples(page, least):
    """Waits until the picture is the mean of so many frames."""
    until(page, f"Number(document.body.dataset.samples) >= {least} && !/moving/.test(document.getElementById('state').textContent)")


def colours(page, side=0):
    """Distinct colours among some pixels, and their mean."""
    return page.evaluate(
        """side => {
            const canvas = document.querySelectorAll('#stage canvas.image')[side];
            const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
            const seen = new Set();
            let sum = 0;
            for (let i = 0; i < data.length; i += 4) { seen.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]); sum += data[i]; }
            return [seen.size, 4 * sum / data.length];
        }""",
        side,
    )


def check_layout(page, name):
    wide = page.evaluate("document.documentElement.scrollWidth")
    width = page.evaluate("document.documentElement.clientWidth")
    check(wide <= width, f"{name}: {wide} px wide in a window of {width}")
    small = page.evaluate(
        """least => [...document.querySelectorAll('button, select, summary, input:not([type=checkbox]):not([type=range])')]
            .filter(node => node.checkVisibility() && node.getBoundingClientRect().height < least)
            .map(node => node.id || node.textContent.trim())""",
        SMALLEST_TARGET_PX,
    )
    check(not small, f"{name}: too small to be tapped: {small}")


def middle(page):
    page.locator("#stage").scroll_into_view_if_needed()
    box = page.locator("#stage").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def check_orbit(page, name):
    """Drags, and sees pictures of what moves meanwhile."""
    samples(page, 2)
    before = page.evaluate("document.body.dataset.serial")
    x, y = middle(page)
    page.mouse.move(x, y)
    page.mouse.down()
    moved = False
    for step in range(40):
        page.mouse.move(x + 2 * step, y + step / 2)
        page.wait_for_timeout(50)
        moved = moved or "moving" in page.locator("#state").inner_text()
    page.mouse.up()
    check(moved, f"{name}: nothing moves while the mouse drags")
    shown = int(page.evaluate("document.body.dataset.serial")) - int(before)
    check(shown >= 8, f"{name}: {shown} pictures in two seconds of dragging")
    check(page.locator("#camera").input_value() == "", f"{name}: the camera is not free after an orbit")
    samples(page, 1)
    check("--from" in page.locator("#command").inner_text(), f"{name}: the command has no camera")


def check_keys(page, name):
    page.locator("#stage").focus()
    fov = page.locator("#command").inner_text()
    page.keyboard.down("d")
    page.wait_for_timeout(400)
    page.keyboard.up("d")
    samples(page, 1)
    check(page.locator("#command").inner_text() != fov, f"{name}: keys do not fly")


def check_axes(page, name):
    """Every value of every axis is taken, and makes a picture."""
    for select in page.locator("#own select[data-axis]").all():
        axis = select.get_attribute("data-axis")
        usual = select.input_value()
        values = select.evaluate("node => [...node.options].map(option => option.value)")
        for value in values:
            if axis == "runner" and value.startswith("gpu"):
                continue
            if select.is_disabled():
                check(axis in ("gather", "emission"), f"{name}: {axis} is disabled with method basic")
                break
            select.select_option(value)
            page.wait_for_timeout(150)
        failure = page.locator("#failure")
        select.select_option(usual)
        page.wait_for_timeout(100)
        # Asked once: what the last value was refused for may go at any time.
        said = failure.evaluate("node => node.hidden ? '' : node.innerText")
        check(not said or "ray queries" in said, f"{name}: {axis}: {said}")
    for axis, value, wrong in (("radius_px", "2", "-1"), ("max_bounces", "3", "99"), ("paths_per_pixel", "0.5", "x")):
        field = page.locator(f"#axis-0-{axis}")
        for text in (wrong, value):
            field.fill(text)
            field.press("Tab")
            if text == wrong:
                until(page, "!document.getElementById('notice').hidden")
            else:
                until(
                    page,
                    "([axis, text]) => document.getElementById('command').textContent.includes(`--${axis} ${text}`)",
                    [axis.replace("_", "-"), text],
                )
    samples(page, 1)
    check(colours(page)[0] > 50, f"{name}: the picture is empty after axes have changed")


def home(page):
    """Back to the file's camera."""
    page.locator("#camera").select_option("main")
    until(page, "document.getElementById('command').textContent.includes('--camera main')")
    samples(page, 2)


def check_layers(page, name):
    home(page)
    seen = {}
    for layer in page.locator("#layer").evaluate("node => [...node.options].map(option => option.value)"):
        page.locator("#layer").select_option(layer)
        page.wait_for_timeout(700)
        seen[layer] = colours(page)
    check(len({tuple(value) for value in seen.values()}) == len(seen), f"{name}: layers look alike: {seen}")
    page.locator("#layer").select_option("beauty")
    page.locator("#stops").fill("-6")
    until(page, "document.getElementById('scale').textContent.startsWith('-6')")
    page.wait_for_timeout(700)
    check(colours(page)[1] < 0.5 * seen["beauty"][1], f"{name}: exposure changes nothing")
    page.locator("#auto").check()


def check_wipe(page, name):
    page.locator("#against").select_option("reference")
    until(page, "document.getElementById('stage').classList.contains('split')")
    until(page, "!document.getElementById('distance').hidden")
    check(colours(page, 1)[0] > 50, f"{name}: the reference is empty")
    box = page.locator("#stage").bounding_box()
    handle = page.locator("#stage .handle")
    middle_y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] / 2, middle_y)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.2 * box["width"], middle_y)
    page.mouse.up()
    check(abs(int(handle.get_attribute("aria-valuenow")) - 20) <= 2, f"{name}: dragged to {handle.get_attribute('aria-valuenow')}")
    handle.focus()
    page.keyboard.press("ArrowRight")
    check(abs(int(handle.get_attribute("aria-valuenow")) - 22) <= 2, f"{name}: keys do not move the wipe")
    flip = page.locator("#distance tr").first.inner_text()
    check("FLIP" in flip, f"{name}: the distance is {flip}")
    page.locator("#against").select_option("other")
    page.locator("#axis-1-method").select_option("kim2019")
    until(page, "document.getElementById('numbers-other').innerText !== ''")
    page.locator("#against").select_option("nothing")
    until(page, "!document.getElementById('stage').classList.contains('split')")


def check_pick(page, name):
    x, y = middle(page)
    page.mouse.click(x, y)
    until(page, "/m away/.test(document.getElementById('picked').textContent)")
    page.mouse.dblclick(x, y + 10)
    page.wait_for_timeout(300)


def check_inspector(page, name, folder):
    """The pixel in the middle of the caustic: its path, its photons, drawn as lines."""
    home(page)
    page.locator("#inspect").click()
    x, y = middle(page)
    page.mouse.click(x, y)
    until(page, "document.getElementById('inspected').rows.length > 2")
    text = page.locator("#inspected").inner_text()
    check("radius of the disc" in text and "photons" in text, f"{name}: the inspector says {text}")
    drawn = page.evaluate(
        """() => {
            const { width, height } = overlay;
            const { data } = overlay.getContext('2d').getImageData(0, 0, width, height);
            let drawn = 0;
            for (let i = 3; i < data.length; i += 4) drawn += data[i] > 0;
            return drawn;
        }"""
    )
    check(drawn > 20, f"{name}: the inspector draws {drawn} pixels")
    page.screenshot(path=folder / "inspected.png")
    page.locator("#inspect").click()
    check(page.locator("#overlay").is_hidden(), f"{name}: the inspector stays")


def check_objects(page, name):
    """Drags an object and a lamp, and sees the light change."""
    home(page)
    for kind in ("", "(light)"):
        names = page.locator("#node").evaluate("node => [...node.options].map(option => option.textContent)")
        found = [index for index, text in enumerate(names) if index and ("(light)" in text) == bool(kind)]
        if not found:
            continue
        before = colours(page)
        page.locator("#node").select_option(index=found[-1])
        until(page, "!document.getElementById('placing').hidden")
        page.locator("#move").click()
        x, y = middle(page)
        page.mouse.move(x, y)
        page.mouse.down()
        for step in range(12):
            page.mouse.move(x + 4 * step, y - 3 * step)
            page.wait_for_timeout(40)
        page.mouse.up()
        until(page, "!document.getElementById('save-edits').hidden")
        samples(page, 2)
        check(colours(page) != before, f"{name}: an object that is dragged changes nothing")
        page.locator("#move").click()
    command = page.locator("#command").inner_text()
    check("--edits edits.toml" in command, f"{name}: the command has no edits: {command}")


def check_recording(page, name, caustics, folder):
    """An orbit that is recorded is an animation."""
    page.locator("#record").click()
    until(page, "document.getElementById('record').getAttribute('aria-pressed') === 'true'")
    x, y = middle(page)
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(20):
        page.mouse.move(x + 3 * step, y)
        page.wait_for_timeout(40)
    page.mouse.up()
    page.locator("#record").click()
    until(page, "!document.getElementById('save-recording').hidden")
    with page.expect_download() as download:
        page.locator("[data-save='animation.toml']").click()
    download.value.save_as(folder / "animation.toml")
    frames = ["--width", "32", "--height", "18", "--frames", "0..3", "--runner", "cpu", "--force"]
    words = [caustics, "animate", SCENE, "--edits", str(folder / "animation.toml"), "-o", str(folder / "frames-###.exr"), *frames]
    done = subprocess.run(words, capture_output=True, text=True)
    check(done.returncode == 0, f"{name}: {done.stderr}")


def check_saved(page, name, caustics, folder):
    """The copied command is the one that is shown, and the EXR of the page has the bytes of its EXR."""
    samples(page, 3)
    page.locator("#pause").click()
    until(page, "document.getElementById('state').textContent === 'paused'")
    command = page.locator("#command").inner_text()
    page.evaluate("navigator.clipboard.writeText = async (text) => { document.body.dataset.copied = text; }")
    page.locator("#copy").click()
    until(page, "document.body.dataset.copied !== undefined")
    copied = page.evaluate("document.body.dataset.copied")
    check(copied == command and copied.isascii() and copied.isprintable(), f"{name}: {copied!r} is copied of {command!r}")
    saved = {}
    for file in ("image.exr", "image.png"):
        with page.expect_download() as download:
            page.locator(f"[data-save='{file}']").click()
        saved[file] = folder / file
        download.value.save_as(saved[file])
    words = shlex.split(command)
    check(words[:3] == ["caustics", "render", SCENE], f"{name}: the command is {command}")
    words[0] = caustics
    if "edits.toml" in words:
        with page.expect_download() as download:
            page.locator("[data-save='edits.toml']").click()
        download.value.save_as(folder / "edits.toml")
        words[words.index("edits.toml")] = str(folder / "edits.toml")
    words[words.index("image.exr")] = str(folder / "again.exr")
    words[words.index("image.png")] = str(folder / "again.png")
    done = subprocess.run([*words, "--force"], env={**os.environ, "SOURCE_DATE_EPOCH": "0"}, capture_output=True, text=True)
    check(done.returncode == 0, f"{name}: {command}: {done.stderr}")
    digest = lambda path: hashlib.sha256(path.read_bytes()).hexdigest() if path.exists() else None
    check(digest(saved["image.exr"]) == digest(folder / "again.exr"), f"{name}: the EXR is not that of {command}")
    check(saved["image.png"].read_bytes()[:4] == b"\x89PNG", f"{name}: the PNG is none")
    page.locator("#pause").click()
    until(page, "document.getElementById('state').textContent !== 'paused'")


def check_onlookers(context, page, address, name):
    other = opened(context, address, f"{name}, onlooker")
    until(other, "document.body.classList.contains('onlooker')")
    check(other.locator("#layer").is_disabled(), f"{name}: an onlooker can steer")
    other.locator("#take").click()
    until(page, "document.body.classList.contains('onlooker')")
    until(other, "!document.getElementById('layer').disabled")
    other.close()
    until(page, "!document.body.classList.contains('onlooker')")


def check_time(browser, caustics, folder):
    """A scene that moves plays and is scrubbed; a page outlives the program and tells the next one what it wanted."""
    token = "0123456789abcdef0123456789abcdef"
    program = Program(caustics, sys.argv[3:], folder, "moving-caster", token)
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    page = context.new_page()
    page.goto(program.address)
    samples(page, 1)
    still = colours(page)
    page.locator("#play").click()
    until(page, "Number(document.getElementById('time').value) > 0.3")
    check("moving" in page.locator("#state").inner_text(), "time: nothing moves while it plays")
    page.locator("#play").click()
    samples(page, 1)
    check(colours(page) != still, "time: the picture does not change")
    page.locator("#layer").select_option("caustics")
    page.locator("#axis-0-max_bounces").fill("4")
    page.locator("#axis-0-max_bounces").press("Tab")
    until(page, "document.getElementById('command').textContent.includes('--max-bounces 4')")
    time_of = "document.getElementById('command').textContent.match(/--time ([0-9.]+)/)[1]"
    was = page.evaluate(time_of)
    port = program.address.split(":")[2].split("/")[0]
    program.end()
    until(page, "document.body.classList.contains('lost')")
    program = Program(caustics, [*sys.argv[3:], "--port", port], folder, "moving-caster", token)
    until(page, "!document.body.classList.contains('lost')")
    until(page, "document.getElementById('command').textContent.includes('--max-bounces 4')")
    check(page.evaluate(time_of) == was, f"restored: the time is {page.evaluate(time_of)}, and was {was}")
    until(page, "document.getElementById('layer').value === 'caustics'")
    context.close()
    program.end()


def fnv1a(data):
    """The hash of kernels.lock: FNV-1a of 64 bits, with a separator behind."""
    value = 0xCBF29CE484222325
    for byte in (*data, 0xFF):
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return f"{value:016x}"


def check_kernels(browser, caustics, folder):
    """On a Vulkan device: new kernels are taken while the program runs, wrong ones are told and do no harm."""
    kernels = folder / "kernels"
    kernels.mkdir(exist_ok=True)
    for name in ("base.spv", "rayquery.spv", "kernels.lock"):
        shutil.copy(ROOT / "kernels" / name, kernels)
    lock = (kernels / "kernels.lock").read_text()

    def relocked(name, value):
        """The lock with another hash under this name."""
        return re.sub(rf'^("?{re.escape(name)}"? = ").*"', rf'\g<1>{value}"', lock, flags=re.MULTILINE)

    program = Program(caustics, ["--runner", "gpu", "--kernels", str(kernels)], folder)
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    page = context.new_page()
    page.goto(program.address)
    samples(page, 1)
    says = lambda text: text in (folder / "program.log").read_text()
    # Another generator in its head makes another module of the same code.
    module = bytearray((kernels / "rayquery.spv").read_bytes())
    check(fnv1a(module) in lock, "kernels: this script hashes otherwise than the lock")
    module[8] ^= 1
    (kernels / "rayquery.spv").write_bytes(module)
    taken = relocked("rayquery.spv", fnv1a(module))
    (kernels / "kernels.lock").write_text(taken)
    end = time.monotonic() + PATIENCE_S
    while not says("new kernels") and time.monotonic() < end:
        page.wait_for_timeout(100)
    check(says("new kernels"), "kernels: new ones are not taken")
    samples(page, 1)
    lock = taken
    (kernels / "kernels.lock").write_text(relocked("interface", "0000000000000000"))
    until(page, "/build again/.test(document.getElementById('failure').textContent)")
    page.screenshot(path=folder / "wrong-kernels.png")
    (kernels / "kernels.lock").write_text(lock)
    until(page, "document.getElementById('failure').hidden")
    samples(page, 1)
    context.close()
    program.end()


def main():
    caustics, folder = sys.argv[1], Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    program = Program(caustics, sys.argv[3:], folder)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        context = browser.new_context(viewport={"width": 1280, "height": 900})
        page = opened(context, program.address, "page")
        check_orbit(page, "page")
        check_keys(page, "page")
        check_layers(page, "page")
        check_wipe(page, "page")
        check_pick(page, "page")
        check_inspector(page, "page", folder)
        check_onlookers(context, page, program.address, "page")
        check_axes(page, "page")
        check_saved(page, "page", caustics, folder)
        check_objects(page, "page")
        check_saved(page, "page, edited", caustics, folder)
        check_recording(page, "page", caustics, folder)
        context.close()
        for width in (1280, 390):
            for scheme in ("light", "dark"):
                name = f"{width}-{scheme}"
                viewport = {"width": width, "height": 844}
                context = browser.new_context(viewport=viewport, color_scheme=scheme, has_touch=width < 500)
                page = opened(context, program.address, name)
                samples(page, 2)
                check_layout(page, name)
                page.locator("#against").select_option("other")
                until(page, "document.getElementById('stage').classList.contains('split')")
                check_layout(page, f"{name}, wipe")
                page.screenshot(path=folder / f"{name}.png", full_page=True)
                page.locator("#against").select_option("nothing")
                context.close()
        program.end()
        check_time(browser, caustics, folder)
        if os.environ.get("CAUSTICS_REQUIRE_GPU"):
            check_kernels(browser, caustics, folder)
        browser.close()
    if failures:
        raise SystemExit(1)
    print("the viewer does what it should")


try:
    main()
finally:
    for each in programs:
        each.kill()
