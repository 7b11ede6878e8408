"""The page of `render view` in a real browser, headless Chromium over its DevTools protocol.

    python tests/peers/view_browser.py target/release/render [--scene SCENE.xml] [--pictures DIR]

It loads, the picture comes to rest, dragging, keys, wheel, touch and every control change it and it comes to rest again, nothing is
wrong in the console, a wrong address is refused, Ctrl-C ends it cleanly. `--pictures` keeps what it looks like at the width of a desk and
of a phone. Needs `pip install websockets` and a `chromium`; skips where one of them is not there.
"""

import argparse
import base64
import json
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from pathlib import Path

try:
    from websockets.sync.client import connect
except ImportError:
    sys.exit(print("skipped: pip install websockets") or 0)

ROOT = Path(__file__).resolve().parents[2]
BROWSERS = ["chromium", "chromium-browser", "google-chrome", "chrome"]
PATIENCE = 120


class Page:
    """A page of the browser."""

    def __init__(self, socket):
        self.socket, self.number, self.wrong = socket, 0, []

    def ask(self, method, **parameters):
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": parameters}))
        while True:
            told = json.loads(self.socket.recv(timeout=PATIENCE))
            self.note(told)
            if told.get("id") == self.number:
                assert "error" not in told, f"{method}: {told['error']}"
                return told["result"]

    def note(self, told):
        method, what = told.get("method"), told.get("params", {})
        if method == "Runtime.exceptionThrown":
            self.wrong.append(what["exceptionDetails"].get("exception", what["exceptionDetails"]))
        if method == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning", "assert"):
            self.wrong.append([a.get("value") for a in what["args"]])
        if method == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
            self.wrong.append(what["entry"]["text"])

    def value(self, expression):
        found = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in found, f"{expression}: {found['exceptionDetails']}"
        return found["result"].get("value")

    def wait(self, expression, what, seconds=PATIENCE):
        end = time.monotonic() + seconds
        while not self.value(expression):
            assert time.monotonic() < end, f"{what}: not after {seconds} s; the page says {self.value('document.body.innerText')!r}"
            time.sleep(0.05)

    def picture(self):
        return self.value("document.getElementById('picture').toDataURL('image/png')")

    def settled(self):
        """The picture when it is there and nothing is on its way."""
        self.wait("document.getElementById('stage').textContent === 'Ready'", "the picture comes to rest")
        frames = "Number(document.getElementById('picture').dataset.frames || 0)"
        before = -1
        while before != (now := self.value(frames)):
            before = now
            time.sleep(0.4)
        return self.picture()

    def changes(self, do, what):
        """What is done changes the picture, which comes to rest again."""
        before = self.settled()
        do()
        self.wait("true", what)
        end = time.monotonic() + PATIENCE
        while (after := self.settled()) == before:
            assert time.monotonic() < end, f"{what}: the picture stays as it was"
        print(f"ok: {what}")
        return after

    def mouse(self, kind, x, y, **more):
        self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def drag(self, dx, dy, button="left"):
        x, y = self.middle()
        mask = {"left": 1, "right": 2}[button]
        self.mouse("mousePressed", x, y, button=button, buttons=mask, clickCount=1)
        for i in range(1, 6):
            self.mouse("mouseMoved", x + dx * i / 5, y + dy * i / 5, button=button, buttons=mask)
        self.mouse("mouseReleased", x + dx, y + dy, button=button, clickCount=1)

    def middle(self):
        box = self.value("(({x, y, width, height}) => [x + width / 2, y + height / 2])(document.getElementById('picture').getBoundingClientRect())")
        return box

    def key(self, key, code, seconds=0.0):
        number = {"windowsVirtualKeyCode": 27} if key == "Escape" else {}
        self.ask("Input.dispatchKeyEvent", type="keyDown", key=key, code=code, text=key if len(key) == 1 else "", **number)
        time.sleep(seconds)
        self.ask("Input.dispatchKeyEvent", type="keyUp", key=key, code=code, **number)

    def touch(self, *ways):
        """Fingers that go from one point to another, each."""
        at = lambda t: [{"x": a[0] + (b[0] - a[0]) * t, "y": a[1] + (b[1] - a[1]) * t, "id": i} for i, (a, b) in enumerate(ways)]
        self.ask("Input.dispatchTouchEvent", type="touchStart", touchPoints=at(0))
        for i in range(1, 6):
            self.ask("Input.dispatchTouchEvent", type="touchMove", touchPoints=at(i / 5))
        self.ask("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def choose(self, name, value, event):
        self.value(f"(e => {{ e.value = {json.dumps(value)}; e.dispatchEvent(new Event('{event}', {{bubbles: true}})) }})(document.getElementById('{name}'))")

    def click(self, name):
        self.value(f"document.getElementById('{name}').click()")

    def shot(self, folder, name):
        if folder:
            data = self.ask("Page.captureScreenshot", format="png")["data"]
            folder.mkdir(parents=True, exist_ok=True)
            (folder / f"{name}.png").write_bytes(base64.b64decode(data))

    def size(self, width, height, phone):
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=2 if phone else 1, mobile=phone)
        self.ask("Emulation.setTouchEmulationEnabled", enabled=phone, maxTouchPoints=5)
        time.sleep(0.5)
        assert self.value("document.documentElement.scrollWidth <= innerWidth"), f"wider than {width} pixels"


def status(address, **headers):
    try:
        with urllib.request.urlopen(urllib.request.Request(address, headers=headers)) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


def desk(page, pictures):
    page.size(1280, 800, False)
    page.settled()
    page.shot(pictures, "desk")
    page.changes(lambda: page.drag(120, 30), "dragging looks around")
    page.changes(lambda: page.drag(60, 0, "right"), "dragging with the right button goes aside")
    page.changes(lambda: page.key("w", "KeyW", 0.4), "W walks")
    page.changes(lambda: page.key("ArrowLeft", "ArrowLeft", 0.3), "arrow keys turn")
    x, y = page.middle()
    page.changes(lambda: page.mouse("mouseWheel", x, y, deltaX=0, deltaY=-120), "the wheel goes ahead")
    page.changes(lambda: page.click("home"), "back to the start")
    page.changes(lambda: page.choose("stops", "1.5", "input"), "exposure")
    page.changes(lambda: page.choose("look", "standard", "change"), "look")
    page.changes(lambda: page.click("dots"), "dots")
    page.changes(lambda: page.click("zones"), "circles")
    page.shot(pictures, "desk-records")
    page.changes(lambda: (page.click("dots"), page.click("zones")), "without them")
    page.choose("tau", "85", "input")
    page.changes(lambda: page.choose("tau", "85", "change"), "tau")
    for method in page.value("[...document.getElementById('method').options].map(o => o.value)"):
        page.choose("method", method, "change")
        page.wait(f"status.method === '{method}' && status.stage === 'settled'", method)
        none = page.value("document.getElementById('records').textContent === 'no records'")
        assert none == (method == "path"), method
        print(f"ok: method {method}")
    page.changes(lambda: page.choose("method", "auto", "change"), "back to auto")
    for way in page.value("[...document.getElementById('interpolation').options].map(o => o.value)"):
        page.choose("interpolation", way, "change")
        page.wait(f"status.interpolation === '{way}' && status.stage === 'settled'", way)
        print(f"ok: records by {way}")
    page.click("mark")
    page.wait("saved.length === 1", "a view is saved")
    page.key("v", "KeyV")
    page.wait("saved.length === 2", "a view is saved by its key")
    text = page.value("document.getElementById('saved-line').value")
    assert text.startswith("frame,eye_x") and text.count("\n") == 3 and "\n49," in text, text
    page.click("record")
    page.wait("status.recording !== null && document.getElementById('record').textContent === 'End recording'", "recording")
    page.key("w", "KeyW", 0.3)
    page.click("record")
    page.wait("status.recording === null", "the end of the recording")
    page.key("?", "Slash")
    page.wait("document.getElementById('help').open", "help")
    page.shot(pictures, "desk-help")
    page.key("Escape", "Escape")
    page.wait("!document.getElementById('help').open", "no help")
    return text


def phone(page, pictures):
    page.size(390, 844, True)
    page.settled()
    page.shot(pictures, "phone")
    places = "new Set([...document.querySelectorAll('.pad button')].map(b => JSON.stringify(b.getBoundingClientRect()))).size"
    assert page.value(places) == page.value("document.querySelectorAll('.pad button').length") > 1, "buttons to walk lie on each other"
    x, y = page.middle()
    page.changes(lambda: page.touch(((x, y), (x + 80, y + 10))), "a finger looks around")
    page.changes(lambda: page.touch(((x - 20, y), (x - 80, y)), ((x + 20, y), (x + 80, y))), "two fingers go ahead")
    page.click("panel-toggle")
    time.sleep(0.5)
    page.shot(pictures, "phone-settings")
    page.click("panel-toggle")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("render")
    parser.add_argument("--scene", default=str(ROOT / "tests/scenes/cornell-glossy.xml"))
    parser.add_argument("--width", default="160")
    parser.add_argument("--spp", default="4")
    parser.add_argument("--pictures", type=Path)
    args = parser.parse_args()
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if not browser:
        return print("skipped: there is no chromium")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        command = [args.render, "view", args.scene, "--width", args.width, "--spp", args.spp, "--tau", "0.2", "--tables", ROOT / "tables", "--cache", folder / "a.cache", "--record", folder / "walk.csv"]
        view = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--remote-debugging-port=0", f"--user-data-dir={folder / 'profile'}", "about:blank"]
        chrome = subprocess.Popen([browser, *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            address = view.stdout.readline().strip()
            assert address.startswith("http://127.0.0.1:"), address
            assert status(address) == 200 and status(address[:-2] + ("0/" if address[-2] != "0" else "1/")) == 403
            assert status(address, Host="example.com") == 421
            print("ok: a wrong address is refused")
            ports = folder / "profile/DevToolsActivePort"
            end = time.monotonic() + PATIENCE
            while not (ports.exists() and len(ports.read_text().split()) == 2):
                assert time.monotonic() < end and chrome.poll() is None, "the browser does not start"
                time.sleep(0.1)
            port = ports.read_text().split()[0]
            pages = json.loads(urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list").read())
            target = next(p for p in pages if p["type"] == "page")["webSocketDebuggerUrl"]
            with connect(target, max_size=1 << 28) as socket:
                page = Page(socket)
                for domain in ("Page", "Runtime", "Log"):
                    page.ask(f"{domain}.enable")
                page.ask("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(folder / "downloads"))
                page.ask("Page.navigate", url=address)
                page.wait("document.readyState === 'complete' && status && status.stage", "the page loads")
                path = desk(page, args.pictures)
                phone(page, args.pictures)
                assert not page.wrong, f"in the console: {page.wrong}"
                print("ok: nothing is wrong in the console")
                # Jobs in the background of a script ignore Ctrl-C; this ends it in the same way.
                view.send_signal(signal.SIGTERM)
                assert view.wait(PATIENCE) == 0, "Ctrl-C"
                page.wait("document.getElementById('notice').textContent.includes('has ended')", "the page is told of the end")
            assert (folder / "a.cache").exists()
            (folder / "views.csv").write_text(path)
            walks = [folder / "views.csv", folder / "walk.csv", *(folder / "downloads").glob("*.csv")]
            assert len(walks) == 3, walks
            for walk in walks:
                out = folder / "frames" / walk.stem
                subprocess.run([args.render, "walk", args.scene, "--path", walk, "--frames", "1", "--width", "16", "--spp", "1", "-o", out / "####.png"], check=True, capture_output=True)
            print("ok: saved views and walks are paths")
        finally:
            for process in (view, chrome):
                if process.poll() is None:
                    process.terminate()
                    process.wait()
    print("passed")


if __name__ == "__main__":
    main()
