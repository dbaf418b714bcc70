#!/usr/bin/env python3
"""Measures `caustics view`: rates.py CAUSTICS SCENE WIDTH HEIGHT SECONDS [view's options].

Drags for so many seconds in headless Chromium and prints frames a second, the time from a mouse's move to the image that shows it
(median and 95th percentile), the memory of the program at the start, in the middle and at the end, and what the server spends on an
image (tone mapping and encoding): on small ones while something moves, then for twenty seconds on those of the whole size. Chromium
draws on the same cores.
"""

import math
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

WATCH = """() => {
    const kept = window.kept = { latency: [], encode: [], bytes: [], serials: 0 };
    const node = document.body;
    new MutationObserver(() => {
        kept.serials += 1;
        if (node.dataset.latency) kept.latency.push(Number(node.dataset.latency));
        if (node.dataset.encode) kept.encode.push(Number(node.dataset.encode));
    }).observe(node, { attributeFilter: ['data-serial'] });
}"""


def resident(pid):
    """Memory of a process (MB)."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def main():
    caustics, scene, width, height, seconds = sys.argv[1:6]
    with tempfile.NamedTemporaryFile("w+") as log, sync_playwright() as playwright:
        command = [caustics, "view", scene, "--port", "0", "--width", width, "--height", height, *sys.argv[6:]]
        program = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=log)
        try:
            found = None
            while not found:
                time.sleep(0.1)
                found = re.search(r"http://\S+", Path(log.name).read_text())
            browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            page.goto(found[0])
            while not page.evaluate("Number(document.body.dataset.samples || 0) >= 1"):
                time.sleep(0.1)
            page.evaluate(WATCH)
            box = page.locator("#stage").bounding_box()
            x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
            page.mouse.move(x, y)
            page.mouse.down()
            memory, start, step = [resident(program.pid)], time.monotonic(), 0
            while (passed := time.monotonic() - start) < float(seconds):
                step += 1
                # To and fro, so that the scene stays in view.
                page.mouse.move(x + 40 * ((step // 40) % 2 * 2 - 1) * (step % 40) / 40, y + step % 7)
                time.sleep(0.03)
                if len(memory) == 1 and passed > float(seconds) / 2:
                    memory.append(resident(program.pid))
            page.mouse.up()
            memory.append(resident(program.pid))
            kept = page.evaluate("window.kept")
            size = page.locator("#numbers td").first.text_content()
            while page.evaluate("document.querySelector('.image').width") != int(width):
                time.sleep(0.1)
            page.evaluate(WATCH)
            time.sleep(20)
            whole = page.evaluate("window.kept.encode")
            latency = sorted(kept["latency"])
            print(
                f"{scene} {width}x{height}: {kept['serials'] / float(seconds):.1f} frames/s at {size}, latency "
                f"{statistics.median(latency):.0f} ms, 95 % within {latency[int(0.95 * len(latency))]:.0f} ms; encoding "
                f"{statistics.median(kept['encode']):.1f} ms, of the whole size {statistics.median(whole or [math.nan]):.1f} ms ({len(whole)} images); memory {' '.join(f'{value:.0f}' for value in memory)} MB"
            )
            browser.close()
        finally:
            program.kill()


main()
