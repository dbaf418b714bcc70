#!/usr/bin/env python3
"""Drives `caustics view` in headless Chromium: view.py CAUSTICS FOLDER_FOR_SCREENSHOTS [view's options].

Checks that the console has no error, that images arrive, that dragging orbits within the rate, that every parameter changes and renders,
that the wipe follows, and that a pixel can be inspected. The EXR must have the bits of the copied command, a second page must not
steer, and Ctrl-C must end the program. Checks the layout at 390, 1280 and 2560 px, light and dark, and that its checks notice faults.
With CAUSTICS_REQUIRE_GPU also exchanges the kernels of a Vulkan device. Prints all failures and exits with 1 if there are any.
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
# Minimum height of a touch target; see tests/browser/report.py.
SMALLEST_TARGET_PX = 36

failures = []
# All programs that were started.
programs = []


def check(holds, what):
    """Notes a failure and continues, so that one run finds all of them."""
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
        """Ends the program after a failure, if it still runs."""
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
    """Waits until an expression holds. The page's policy refuses `wait_for_function`."""
    end = time.monotonic() + PATIENCE_S
    while not page.evaluate(expression, argument):
        if time.monotonic() > end:
            raise TimeoutError(f"{expression} does not come to hold; {page.locator('body').inner_text()[:600]}")
        page.wait_for_timeout(50)


def watch(page, name):
    """Checks that the console has neither errors nor warnings."""
    # Ignore the warning about this script's own reading of pixels.
    mine = "getImageData"
    page.on("console", lambda line: check(mine in line.text or line.type not in ("error", "warning"), f"{name}: console: {line.text}"))
    page.on("pageerror", lambda error: check(False, f"{name}: {error}"))


def unfold(page):
    """Opens all sections of the panel."""
    page.evaluate("document.querySelectorAll('details').forEach(node => { node.open = true; })")


def opened(context, address, name):
    page = context.new_page()
    page.set_default_timeout(1000 * PATIENCE_S)
    watch(page, name)
    page.goto(address)
    until(page, "document.body.dataset.serial")
    return page


def samples(page, least):
    """Waits until the image is the mean of this number of frames."""
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


def layout_faults(page):
    """Faults of the layout, in words."""
    return page.evaluate(
        """least => {
            const faults = [];
            const fault = (holds, text) => { if (!holds) faults.push(text); };
            const box = (selector) => document.querySelector(selector).getBoundingClientRect();
            const near = (a, b) => Math.abs(a - b) < 1;
            const root = document.documentElement;
            const panel = document.getElementById('panel');
            fault(root.scrollWidth <= innerWidth && document.body.scrollWidth <= innerWidth, `overflow: the page is ${document.body.scrollWidth} px wide`);
            const tall = Math.max(root.scrollHeight, document.body.scrollHeight);
            fault(tall <= innerHeight, `overflow: the page is ${tall} px tall`);
            // The view takes what bar and panel leave of the window.
            const [view, stage, canvas, bar] = ['.view', '#stage', '#stage canvas', '.bar'].map(box);
            const isBeside = bar.left >= view.right - 1;
            if (panel.hidden) {
                const taken = getComputedStyle(document.querySelector('.bar')).position === 'fixed' ? 0 : bar.height;
                fault(near(view.width, innerWidth) && near(view.height + taken, innerHeight), `view: ${view.width} x ${view.height} px without a panel`);
            } else if (isBeside) {
                fault(near(view.height, innerHeight) && near(view.width + bar.width, innerWidth), `view: ${view.width} x ${view.height} px beside the panel`);
                fault(near(bar.height + panel.offsetHeight, innerHeight), `panel: ${panel.offsetHeight} px tall`);
            } else {
                fault(near(view.width, innerWidth) && near(view.height + bar.height + panel.offsetHeight, innerHeight), `view: ${view.width} x ${view.height} px above the panel`);
                fault(panel.offsetHeight >= 0.25 * innerHeight, `panel: ${panel.offsetHeight} px tall`);
            }
            // The image fills the view in one direction, and keeps its aspect.
            const [width, height] = ['width', 'height'].map(id => Number(document.getElementById(id).value));
            fault(near(stage.width, view.width) || near(stage.height, view.height), `fill: the image has ${stage.width} x ${stage.height} px of ${view.width} x ${view.height}`);
            fault(stage.width < view.width + 1 && stage.height < view.height + 1, `fill: the image is cut`);
            fault(Math.abs(stage.width / stage.height / (width / height) - 1) < 0.01, `aspect: ${stage.width} x ${stage.height} px for ${width} x ${height}`);
            fault(near(canvas.width, stage.width) && near(canvas.height, stage.height), `fill: the canvas has ${canvas.width} x ${canvas.height} px`);
            // The panel scrolls by itself.
            if (!panel.hidden) {
                fault(panel.scrollWidth <= panel.clientWidth, `overflow: the panel is ${panel.scrollWidth} px wide in ${panel.clientWidth}`);
                const isLong = [...panel.children].reduce((sum, node) => sum + node.offsetHeight, 0) > panel.clientHeight;
                panel.scrollTop = 50;
                fault(!isLong || panel.scrollTop > 0, 'scroll: the panel does not');
                fault(near(box('#stage').top, stage.top), 'scroll: the image moves with the panel');
                panel.scrollTop = 0;
            }
            const isCompared = document.getElementById('against').value === 'other';
            fault(panel.hidden || document.getElementById('other').checkVisibility() === isCompared, 'unused: the second setting is in sight only where it is used');
            const hit = (node) => node.type === 'checkbox' ? node.closest('label') : node;
            const small = [...document.querySelectorAll('button, select, summary, input')]
                .filter(node => node.checkVisibility() && hit(node).getBoundingClientRect().height < least)
                .map(node => node.id || node.textContent.trim());
            fault(!small.length, `touch: too small: ${small}`);
            return faults;
        }""",
        SMALLEST_TARGET_PX,
    )


def check_layout(page, name):
    faults = layout_faults(page)
    check(not faults, f"{name}: {faults}")


# Faults by style sheets, and the words by which the check names them.
BROKEN = {
    "#stage { width: 50cqw; }": "fill: the image has",
    "#stage { width: 120cqw; }": "fill: the image is cut",
    "#stage { aspect-ratio: 1; }": "aspect",
    "#stage canvas { height: 50%; }": "fill: the canvas",
    ".view { margin: 20px; }": "view",
    "#panel { overflow: clip; }": "scroll",
    "#panel { overflow: visible; }": "scroll",
    ".field { width: 2000px; }": "overflow: the panel",
    "body { width: 110vw; }": "overflow: the page",
    "#other[hidden] { display: block; }": "unused",
    "#toggle { height: 20px; min-height: 0; }": "touch",
}


def check_broken_layouts(page, name):
    """Breaks the layout by style sheets; the check must notice each."""
    for sheet, words in BROKEN.items():
        page.evaluate("text => { const sheet = new CSSStyleSheet(); sheet.replaceSync(text); document.adoptedStyleSheets = [sheet]; }", sheet)
        faults = layout_faults(page)
        check(any(fault.startswith(words) for fault in faults), f"{name}: {sheet} is not noticed: {faults}")
    page.evaluate("document.adoptedStyleSheets = []")
    check_layout(page, f"{name}, mended")


def check_panel(page, name, folder):
    """Hides the panel by its button and shows it by a key; a key that is typed into a field does neither."""
    page.locator("#toggle").click()
    check(page.locator("#panel").is_hidden(), f"{name}: the panel stays")
    check(page.locator("#toggle").get_attribute("aria-expanded") == "false", f"{name}: the button says that the panel is shown")
    check_layout(page, f"{name}, without panel")
    page.screenshot(path=folder / f"{name}-bare.png")
    page.locator("#stage").focus()
    page.keyboard.press("h")
    check(page.locator("#panel").is_visible(), f"{name}: the panel does not return")
    page.locator("#parameter-0-radius_px").focus()
    page.keyboard.press("h")
    check(page.locator("#panel").is_visible(), f"{name}: a letter in a field hides the panel")
    page.locator("#parameter-0-radius_px").fill("1")


def middle(page):
    page.locator("#stage").scroll_into_view_if_needed()
    box = page.locator("#stage").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def check_orbit(page, name):
    """Drags, and counts the images that arrive meanwhile."""
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
    check(shown >= 8, f"{name}: {shown} images in two seconds of dragging")
    check(page.locator("#camera").input_value() == "", f"{name}: the camera is not free after an orbit")
    samples(page, 1)
    check("--from" in page.locator("#command").inner_text(), f"{name}: the command has no camera")


def check_keys(page, name):
    page.locator("#stage").focus()
    before = page.locator("#command").inner_text()
    page.keyboard.down("d")
    page.wait_for_timeout(400)
    page.keyboard.up("d")
    samples(page, 1)
    check(page.locator("#command").inner_text() != before, f"{name}: keys do not fly")


def check_parameters(page, name):
    """Sets every value of every parameter, and renders it. Parameters that do not apply are out of sight: the sharing of indirect
    light appears when nothing else smooths or reuses path-traced light."""
    smoothing = [page.locator(f"#parameter-0-{parameter}") for parameter in ("path_history", "denoiser")]
    before = [select.input_value() for select in smoothing]
    check(page.locator("#parameter-0-indirect_share").is_hidden(), f"{name}: what does not apply is shown")
    for select in smoothing:
        select.select_option("none")
    for select in page.locator("#own select[data-parameter]").all():
        parameter = select.get_attribute("data-parameter")
        until(page, "key => document.getElementById(`parameter-0-${key}`).checkVisibility()", parameter)
        default = select.input_value()
        values = select.evaluate("node => [...node.options].map(option => option.value)")
        for value in values:
            if parameter == "runner" and value.startswith("gpu"):
                continue
            select.select_option(value)
            page.wait_for_timeout(150)
        failure = page.locator("#failure")
        select.select_option(default)
        page.wait_for_timeout(100)
        # Read the message once: it may vanish between two calls.
        message = failure.evaluate("node => node.hidden ? '' : node.innerText")
        check(not message or "ray queries" in message, f"{name}: {parameter}: {message}")
    for select, value in zip(smoothing, before):
        select.select_option(value)
    page.locator("#parameter-0-method").select_option("path")
    until(page, "document.getElementById('parameter-0-gather').closest('.field').hidden")
    note = page.locator("#not-applicable-0").inner_text()
    check("gather" in note and page.locator("#parameter-0-gather").is_hidden(), f"{name}: gather with method path: {note!r}")
    page.locator("#parameter-0-method").select_option("basic")
    until(page, "document.getElementById('parameter-0-gather').checkVisibility()")
    for parameter, value, wrong in (("radius_px", "2", "-1"), ("max_bounces", "3", "99"), ("paths_per_pixel", "0.5", "x")):
        field = page.locator(f"#parameter-0-{parameter}")
        for text in (wrong, value):
            field.fill(text)
            field.press("Tab")
            if text == wrong:
                until(page, "!document.getElementById('notice').hidden")
            else:
                until(
                    page,
                    "([option, text]) => document.getElementById('command').textContent.includes(`--${option} ${text}`)",
                    [parameter.replace("_", "-"), text],
                )
    samples(page, 1)
    check(colours(page)[0] > 50, f"{name}: the image is empty after parameters have changed")


def home(page):
    """Returns to the file's camera."""
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
    until(page, "document.getElementById('scale').textContent.startsWith('exposure -6')")
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
    check(page.locator("#other").is_hidden(), f"{name}: the second setting is in sight without another setting")
    page.locator("#against").select_option("other")
    page.locator("#parameter-1-method").select_option("kim2019")
    until(page, "document.querySelector('#numbers-other td')")
    page.locator("#against").select_option("nothing")
    until(page, "!document.getElementById('stage').classList.contains('split')")
    check(page.locator("#other").is_hidden(), f"{name}: the second setting stays")


def check_pick(page, name):
    x, y = middle(page)
    page.mouse.click(x, y)
    until(page, "/m from the camera/.test(document.getElementById('picked').textContent)")
    page.mouse.dblclick(x, y + 10)
    page.wait_for_timeout(300)


def check_inspector(page, name, folder):
    """Inspects the pixel in the middle of the caustic: its path and its photons are drawn as lines."""
    home(page)
    page.locator("#inspect").click()
    x, y = middle(page)
    page.mouse.click(x, y)
    until(page, "document.getElementById('inspected').rows.length > 2")
    text = page.locator("#inspected").inner_text()
    check("radius of the collection point" in text and "photons" in text, f"{name}: the inspector says {text}")
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
    """Drags an object and a light, and sees the image change."""
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
    """Records an orbit and renders it as an animation."""
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
    """Copies the command that is shown, and compares its EXR with the page's, byte by byte."""
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
    """Plays a scene that moves. The page outlives the program, and repeats its requests to the next one."""
    token = "0123456789abcdef0123456789abcdef"
    program = Program(caustics, sys.argv[3:], folder, "moving-caster", token)
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    page = context.new_page()
    page.goto(program.address)
    samples(page, 1)
    unfold(page)
    still = colours(page)
    page.locator("#play").click()
    until(page, "Number(document.getElementById('time').value) > 0.3")
    check("moving" in page.locator("#state").inner_text(), "time: nothing moves while it plays")
    page.locator("#play").click()
    samples(page, 1)
    check(colours(page) != still, "time: the image does not change")
    page.locator("#layer").select_option("caustics")
    page.locator("#parameter-0-max_bounces").fill("4")
    page.locator("#parameter-0-max_bounces").press("Tab")
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
    """Hash of kernels.lock: FNV-1a of 64 bits, with a separator at the end."""
    value = 0xCBF29CE484222325
    for byte in (*data, 0xFF):
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return f"{value:016x}"


def check_kernels(browser, caustics, folder):
    """Exchanges kernels on a Vulkan device while the program runs; wrong ones are reported and do no harm."""
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
        unfold(page)
        check_orbit(page, "page")
        check_keys(page, "page")
        check_layers(page, "page")
        check_wipe(page, "page")
        check_pick(page, "page")
        check_inspector(page, "page", folder)
        check_onlookers(context, page, program.address, "page")
        check_parameters(page, "page")
        check_saved(page, "page", caustics, folder)
        check_objects(page, "page")
        check_saved(page, "page, edited", caustics, folder)
        check_recording(page, "page", caustics, folder)
        context.close()
        for width, height in ((2560, 1300), (1280, 844), (390, 844)):
            for scheme in ("light", "dark"):
                name = f"{width}-{scheme}"
                viewport = {"width": width, "height": height}
                context = browser.new_context(viewport=viewport, color_scheme=scheme, has_touch=width < 500)
                page = opened(context, program.address, name)
                samples(page, 2)
                check_layout(page, name)
                page.screenshot(path=folder / f"{name}.png")
                check_panel(page, name, folder)
                unfold(page)
                check_layout(page, f"{name}, unfolded")
                if scheme == "dark":
                    check_broken_layouts(page, name)
                page.locator("#against").select_option("other")
                until(page, "document.getElementById('stage').classList.contains('split')")
                until(page, "!document.getElementById('other').hidden")
                check_layout(page, f"{name}, wipe")
                page.screenshot(path=folder / f"{name}-wipe.png")
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
