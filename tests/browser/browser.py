"""Drives Chromium without a screen: a JSON object per line in, one per line out.

    {"open": ADDRESS}                       the page is loaded; answers how long that took, ms
    {"tab": ADDRESS}                        the same in another tab, which is closed again
    {"run": SCRIPT, "with": [ARGUMENT...]}  the result of a script's `return`
    {"size": [WIDTH, HEIGHT]}               the window's inner size
    {"drag": [[X, Y], [X, Y]]}              the mouse is pressed, moved and released
    {"dark": true}                          the dark colours are preferred
    {"picture": FILE, "whole": true}        a screenshot, of the whole page or of what is seen

An error is answered as {"error": TEXT}. Needs selenium, and Debian's chromium and chromedriver.
"""

import base64
import contextlib
import json
import sys
import tempfile

from selenium import webdriver
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.chrome.service import Service

OPTIONS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
]

DRAG = ["mouseMoved", "mousePressed", "mouseMoved", "mouseReleased"]

LOADED = "const it = performance.getEntriesByType('navigation')[0]; return it.loadEventEnd - it.startTime;"


def act(driver, command: dict):
    if "open" in command:
        driver.get(command["open"])
        return driver.execute_script(LOADED)
    if "tab" in command:
        first = driver.current_window_handle
        driver.switch_to.new_window("tab")
        driver.get(command["tab"])
        driver.close()
        driver.switch_to.window(first)
        return True
    if "run" in command:
        return driver.execute_script(command["run"], *command.get("with", []))
    if "size" in command:
        width, height = command["size"]
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
        return driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    if "drag" in command:
        for (x, y), kind in zip([command["drag"][0]] * 2 + [command["drag"][1]] * 2, DRAG):
            event = {"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1}
            driver.execute_cdp_cmd("Input.dispatchMouseEvent", event)
        return True
    if "picture" in command:
        whole = {"captureBeyondViewport": bool(command.get("whole")), "format": "png"}
        picture = driver.execute_cdp_cmd("Page.captureScreenshot", whole)
        with open(command["picture"], "wb") as file:
            file.write(base64.b64decode(picture["data"]))
        return True
    if "dark" in command:
        scheme = [{"name": "prefers-color-scheme", "value": "dark" if command["dark"] else "light"}]
        return driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": scheme})
    raise ValueError(f"unknown command {command}")


@contextlib.contextmanager
def chromium():
    """A browser, with a profile that ends with it."""
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    with tempfile.TemporaryDirectory() as profile:
        for option in [*OPTIONS, f"--user-data-dir={profile}"]:
            options.add_argument(option)
        driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
        try:
            yield driver
        finally:
            driver.quit()


def main() -> None:
    with chromium() as driver:
        for line in sys.stdin:
            try:
                answer = {"is": act(driver, json.loads(line))}
            except (WebDriverException, ValueError) as error:
                answer = {"error": str(error)}
            print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
