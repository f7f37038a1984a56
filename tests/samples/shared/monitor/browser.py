#!/usr/bin/python3
"""browser.py BIN [--pictures FOLDER]: the operator's page of BIN/midair-demo in a real browser, on a telephone and on a desk.

Needs Debian's chromium, chromium-driver and python3-selenium (tests/run.sh --browser installs them). It prints how long the first
paint and a mute took, and ends with 1 if anything is not as it must be. Clocks are printed, not judged.
"""
import argparse
import http.server
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By

ROOT = pathlib.Path(__file__).resolve().parents[4]
SIZES = {"telephone": (360, 740, True, "dark"), "desk": (1280, 800, False, "light"), "desk, dark": (1280, 800, False, "dark")}
PATIENCE_S = 120.0
HOSTILE = "<img src=x onerror=\"document.title='owned'\">.obj"
problems = []


def check(good, what):
    if not good:
        problems.append(what)
        print("FAILED:", what, flush=True)


def wait_for(condition, what):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        if condition():
            return
        time.sleep(0.05)
    check(False, f"{what} within {PATIENCE_S:.0f} s")


class Demo:
    """midair-demo with its page, as an installation runs it."""

    def __init__(self, folder, programs, model=None):
        self.token_file = folder / "token"
        arguments = [programs / "midair-demo", "--headless", "--frames", "10000000", "--out", folder / "out",
                     "--monitor", "127.0.0.1:0", "--monitor-token-file", self.token_file]
        if model:
            arguments.insert(1, model)
        environment = {key: value for key, value in os.environ.items() if key != "DISPLAY"}
        # It draws as fast as it can; a real one waits for the screen, and leaves the browser its share.
        self.process = subprocess.Popen(["nice", "-n", "15", *map(str, arguments)], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                        text=True, env=environment)
        line = next((line for line in self.process.stderr if line.startswith("the operator's page")), "")
        check(line.startswith("the operator's page is http://127.0.0.1:"), f"the program says where its page is: {line!r}")
        self.url = line.split()[4]
        self.lines = []
        threading.Thread(target=lambda: self.lines.extend(self.process.stderr), daemon=True).start()
        self.token = self.token_file.read_text().strip()

    def signal(self, number):
        self.process.send_signal(number)

    def end(self):
        self.process.terminate()
        check(self.process.wait(60) == 0, "midair-demo ends with 0")


def browser(width, height, is_mobile, scheme, rules=""):
    options = Options()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars"):
        options.add_argument(argument)
    if rules:
        options.add_argument(f"--host-resolver-rules={rules}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                           {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": is_mobile})
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
    return driver


def text(driver, name):
    return driver.find_element(By.ID, name).get_attribute("textContent")


CONTRAST = """
const parts = c => c.match(/[\\d.]+/g).map(Number);
const light = c => { const [r, g, b] = parts(c).map(v => v / 255).map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
                     return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
const ground = e => { for (; e; e = e.parentElement) { const c = getComputedStyle(e).backgroundColor;
                      if (parts(c).length < 4 || parts(c)[3] > 0) return c; } return "rgb(255, 255, 255)"; };
let worst = [99, ""];
for (const e of document.querySelectorAll("h1, h2, button, .big, .sub, .chip, dt, dd, li, footer, #word, #since")) {
    if (!e.offsetParent || !e.textContent.trim()) continue;
    const [a, b] = [light(getComputedStyle(e).color), light(ground(e))].sort((x, y) => y - x);
    const ratio = (a + 0.05) / (b + 0.05);
    if (ratio < worst[0]) worst = [ratio, e.outerHTML.slice(0, 80)];
}
return worst;
"""
PIXELS = """
const image = document.getElementById("picture"), canvas = document.createElement("canvas");
canvas.width = image.naturalWidth; canvas.height = image.naturalHeight;
const context = canvas.getContext("2d");
context.drawImage(image, 0, 0);
return new Set(new Uint32Array(context.getImageData(0, 0, canvas.width, canvas.height).data.buffer)).size;
"""


def check_contrast(driver, name):
    ratio, where = driver.execute_script(CONTRAST)
    check(ratio >= 4.5, f"{name}: a contrast of {ratio:.2f} in {where}")


def look(driver, name, width, height, demo):
    driver.get(f"{demo.url}#token={demo.token}")
    wait_for(lambda: text(driver, "word") == "PLAYING", f"{name}: the page says PLAYING")
    paint_ms = driver.execute_script("return performance.getEntriesByName('first-contentful-paint')[0].startTime")
    print(f"{name}, {width} x {height}: first paint after {paint_ms:.0f} ms", flush=True)
    check("token" not in driver.current_url, f"{name}: the token is in the address")
    check(driver.execute_script("return document.documentElement.scrollWidth") <= width, f"{name}: wider than the screen")
    box = driver.execute_script("return document.getElementById('mute').getBoundingClientRect().toJSON()")
    check(box["top"] >= 0 and box["bottom"] <= height and box["height"] >= 64 and box["width"] >= 300,
          f"{name}: the mute button is at hand: {box}")
    wait_for(lambda: driver.execute_script("return document.getElementById('picture').naturalWidth") > 300, f"{name}: a picture")
    check(driver.execute_script(PIXELS) > 100, f"{name}: the picture shows something")
    wait_for(lambda: "%" in text(driver, "rms") and "ms" in text(driver, "latency") and "dB" in text(driver, "ears"), f"{name}: figures")
    check_contrast(driver, name)
    strangers = driver.execute_script("return performance.getEntriesByType('resource').map(e => e.name)"
                                      ".filter(n => !n.startsWith(location.origin) && !n.startsWith('blob:' + location.origin))")
    check(strangers == [], f"{name}: it asks {strangers}")
    errors = [entry for entry in driver.get_log("browser") if "503 (Service Unavailable)" not in entry["message"]]
    check(errors == [], f"{name}: the browser complains: {errors}")


def mute_and_unmute(driver, name):
    driver.execute_script("document.getElementById('operator').value = 'Ännï <b>';"
                          "document.getElementById('who').requestSubmit()")
    driver.find_element(By.ID, "mute").click()
    wait_for(lambda: text(driver, "word") == "MUTED", f"{name}: MUTED after a click")
    wait_for(lambda: text(driver, "result").startswith("Muted: silent after"), f"{name}: the mute is confirmed")
    print(f"{name}: {text(driver, 'result')}", flush=True)
    wait_for(lambda: "Ännï <b> (127.0.0.1)" in text(driver, "since"), f"{name}: it says who muted")
    check_contrast(driver, name + ", muted")
    driver.find_element(By.ID, "mute").click()
    check("AGAIN" in text(driver, "mute"), f"{name}: one tap only asks: {text(driver, 'mute')}")
    time.sleep(1.0)
    check(text(driver, "word") == "MUTED", f"{name}: one tap doesn't unmute")
    driver.find_element(By.ID, "mute").click()
    wait_for(lambda: text(driver, "word") == "PLAYING", f"{name}: two taps unmute")


def stand_still(driver, demo):
    demo.signal(signal.SIGSTOP)
    wait_for(lambda: text(driver, "word") == "UNKNOWN", "a program that is stopped makes the state UNKNOWN")
    check_contrast(driver, "unknown")
    check("No connection" in text(driver, "alert"), f"the page says why: {text(driver, 'alert')}")
    check(text(driver, "rms") == "–" and text(driver, "latency") == "–", "old figures are gone")
    wait_for(lambda: "old" in text(driver, "note"), "an old picture says so")
    demo.signal(signal.SIGCONT)
    wait_for(lambda: text(driver, "word") == "PLAYING" and text(driver, "alert") == "", "all is back afterwards")


def wrong_token(driver, demo):
    driver.get(demo.url)
    driver.execute_script("sessionStorage.clear()")
    driver.get(demo.url)
    wait_for(lambda: text(driver, "word") == "PLAYING", "looking needs no token")
    driver.find_element(By.ID, "mute").click()
    check("token" in text(driver, "result"), "without a token it asks for one")
    driver.find_element(By.ID, "token").send_keys("0123456789abcdef")
    driver.find_element(By.CSS_SELECTOR, "#who button").click()
    driver.find_element(By.ID, "mute").click()
    wait_for(lambda: text(driver, "result").startswith("NOT MUTED"), "a wrong token is told")
    check(text(driver, "word") == "PLAYING", "and mutes nothing")


def strangers(demo):
    """Another site's page, and a name that leads here, get nothing."""
    page = f"""<form id=f method=post action="{demo.url}mute" target=i></form><iframe name=i src="{demo.url}"></iframe>
<img id=p src="{demo.url}picture"><script>
const tried = []; window.tried = tried;
const note = (name, promise) => promise.then(a => tried.push(name + " " + a.type + " " + a.status), e => tried.push(name + " refused"));
note("read", fetch("{demo.url}status.json"));
note("post", fetch("{demo.url}mute", {{method: "POST", mode: "no-cors"}}));
note("token", fetch("{demo.url}mute", {{method: "POST", headers: {{Authorization: "Bearer {demo.token}"}}}}));
document.getElementById("f").submit();
</script>"""

    class Evil(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(page.encode())

        def log_message(self, *_):
            pass

    server = http.server.HTTPServer(("127.0.0.1", 0), Evil)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    port = demo.url.rstrip("/").rsplit(":", 1)[1]
    driver = browser(800, 600, False, "light", f"MAP evil.example 127.0.0.1:{server.server_port}, MAP rebound.example 127.0.0.1:{port}")
    try:
        driver.get("http://evil.example/")
        wait_for(lambda: len(driver.execute_script("return window.tried")) == 3, "another site's requests end")
        tried = driver.execute_script("return window.tried")
        check("read refused" in tried and "token refused" in tried, f"another site reads or acts: {tried}")
        check(driver.execute_script("return document.getElementById('p').naturalWidth") == 0, "another site shows the picture")
        driver.get(f"http://rebound.example:{port}/")
        check("--monitor-host" in driver.page_source, "a name that leads here is served")
        driver.get(demo.url)
        wait_for(lambda: text(driver, "word") == "PLAYING", "it still plays")
        check("muted" not in text(driver, "events"), f"another site has muted: {text(driver, 'events')}")
    finally:
        driver.quit()
        server.shutdown()


def pictures(driver, demo, folder):
    for name, (width, height) in {"monitor": (1280, 800), "monitor-telephone": (360, 740)}.items():
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                               {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500})
        driver.get(f"{demo.url}#token={demo.token}")
        wait_for(lambda: text(driver, "note") == "" and text(driver, "word") == "PLAYING", "a page to be pictured")
        wait_for(lambda: driver.execute_script("return status.fields.played") > 400, "fields to be counted")
        driver.save_screenshot(str(pathlib.Path(folder) / f"{name}.png"))


def hostile_name(folder, programs):
    model = folder / HOSTILE
    shutil.copy(ROOT / "samples/models/star.obj", model)
    demo = Demo(folder, programs, model)
    driver = browser(360, 740, True, "light")
    try:
        driver.get(demo.url)
        wait_for(lambda: HOSTILE in text(driver, "name"), "a hostile name is shown as it is")
        check(driver.execute_script("return document.querySelectorAll('h1 img, li img').length") == 0, "a name became an element")
        check(driver.title != "owned", "a name became a script")
        demo.end()
        wait_for(lambda: text(driver, "word") == "UNKNOWN", "a program that has ended isn't shown as playing")
    finally:
        driver.quit()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--pictures", help="folder for monitor.png and monitor-telephone.png; nothing else is done")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        demo = Demo(folder, options.programs)
        if options.pictures:
            driver = browser(1280, 800, False, "light")
            pictures(driver, demo, options.pictures)
            driver.quit()
            demo.end()
            return 1 if problems else 0
        strangers(demo)
        for size, (width, height, is_mobile, scheme) in SIZES.items():
            driver = browser(width, height, is_mobile, scheme)
            try:
                look(driver, size, width, height, demo)
                mute_and_unmute(driver, size)
                if is_mobile:
                    stand_still(driver, demo)
                    wrong_token(driver, demo)
            finally:
                driver.quit()
        demo.end()
        check(any("muted by Ännï <b> (127.0.0.1)" in line for line in demo.lines), f"the program says who muted: {demo.lines}")
        hostile_name(folder, options.programs)
    print("the operator's page in a browser:", f"{len(problems)} failed" if problems else "all is well")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
