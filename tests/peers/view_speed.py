"""Frames of `render view`, as its page gets them: the time to the first, and how many come in a second.

    python tests/peers/view_speed.py target/release/render [--scene SCENE.xml] [--width 512] [--height 512] [--tau 0.1] [options of view]

Three parts: standing still while the caches fill; turning into what no record reaches yet; turning to and fro where all records are
there. Needs `pip install websockets`; skips where that is not there.
"""

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

try:
    from websockets.sync.client import connect
except ImportError:
    sys.exit(print("skipped: pip install websockets") or 0)

ROOT = Path(__file__).resolve().parents[2]


class View:
    def __init__(self, socket):
        self.socket, self.status = socket, None

    def send(self, **order):
        self.socket.send(json.dumps(order))

    def frame(self):
        """The next picture; its status is in `status`."""
        while True:
            told = self.socket.recv(timeout=60)
            if isinstance(told, bytes):
                return time.perf_counter()
            told = json.loads(told)
            if told["tell"] == "status":
                self.status = told

    def frames(self, seconds, order=lambda i: None, until=lambda status: False):
        """Times, widths and records of the frames that come meanwhile."""
        start, frames, i = time.perf_counter(), [], 0
        while not frames or frames[-1][0] - start < seconds:
            if (what := order(i)) is not None:
                self.send(**what)
            now = self.frame()
            if until(self.status):
                break
            frames.append((now, self.status["size"][0], self.status["records"]))
            i += 1
        return frames


def told(name, frames):
    if len(frames) < 3:
        return print(f"{name}: {len(frames)} frames")
    times = [t for t, *_ in frames]
    gaps = sorted(b - a for a, b in zip(times, times[1:]))
    widths = sorted(w for _, w, _ in frames)
    print(f"{name}: {1 / (sum(gaps) / len(gaps)):.1f} frames per second, longest gap {1000 * gaps[-1]:.0f} ms, 95 % below {1000 * gaps[int(0.95 * len(gaps))]:.0f} ms, "
          f"width {widths[0]} to {widths[-1]}, median {widths[len(widths) // 2]}; {frames[0][2]} to {frames[-1][2]} records")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("render")
    parser.add_argument("--scene", default=str(ROOT / "tests/scenes/cornell-glossy.xml"))
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--denoised", action="store_true")
    args, more = parser.parse_known_args()
    command = [args.render, "view", args.scene, "--tables", str(ROOT / "tables"), *(more or ["--width", "512", "--height", "512"])]
    started = time.perf_counter()
    view = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        address = view.stdout.readline().strip()
        loaded = time.perf_counter()
        origin = address.split("/", 3)
        with connect(address.replace("http", "ws") + "socket", origin="/".join(origin[:3]), max_size=1 << 28, ping_interval=None) as socket:
            page = View(socket)
            if args.denoised:
                page.send(do="denoise", on=True)
            first = page.frame()
            print(f"loading {loaded - started:.2f} s, then first frame after {first - loaded:.2f} s, {page.status['size'][0]} pixels wide")
            frames = page.frames(120, until=lambda s: s["stage"] in ("refining", "settled"))
            filling = [f for f in frames if f[2]]
            told(f"standing while caches fill, {frames[-1][0] - first:.1f} s" if frames else "filled at once", filling)
            turn = lambda i: {"do": "turn", "yaw": 0.03, "pitch": 0.0}
            told("turning into the unknown", page.frames(args.seconds, turn))
            page.send(do="home")
            page.frames(1)
            fro = lambda i: {"do": "turn", "yaw": 0.01 if i // 20 % 2 == 0 else -0.01, "pitch": 0.0}
            page.frames(2 * args.seconds, fro)
            told("turning where all is known", page.frames(args.seconds, fro))
    finally:
        view.terminate()
        view.wait()


if __name__ == "__main__":
    main()
