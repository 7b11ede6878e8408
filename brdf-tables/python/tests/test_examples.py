"""The examples run, and say what they should; that of Mitsuba only where Mitsuba is installed."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def run(name: str, picture: Path) -> str:
    done = subprocess.run(
        [sys.executable, EXAMPLES / name, picture], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr + done.stdout
    assert picture.stat().st_size > 5_000
    return done.stdout


def test_area_lights(tmp_path):
    assert "from Monte Carlo" in run("area_lights.py", tmp_path / "lights.png")


@pytest.mark.skipif(importlib.util.find_spec("mitsuba") is None, reason="Mitsuba is not installed")
def test_mitsuba_integrator(tmp_path):
    assert "bias" in run("mitsuba_integrator.py", tmp_path / "mitsuba.png")


def test_figure_4(monkeypatch):
    """The cells of the notebook, one after the other; what it finds is what the paper says, and better today."""
    import matplotlib

    matplotlib.use("Agg")
    cells = json.loads((EXAMPLES / "figure4.ipynb").read_text(encoding="utf-8"))["cells"]
    assert all(not cell.get("outputs") for cell in cells), "outputs are not kept in the repository"
    names: dict = {}
    for i, cell in enumerate(c for c in cells if c["cell_type"] == "code"):
        exec(compile("".join(cell["source"]), f"figure4.ipynb, cell {i}", "exec"), names)
    assert len(names["errors"]) == 4
    for case, (of_2015, today) in names["errors"].items():
        published = names["PUBLISHED"][case]
        assert 0.3 * published < of_2015 < 3.0 * published, case
        assert today < 0.05, case
