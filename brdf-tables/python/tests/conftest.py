"""Caps and directions that tests share."""

import numpy as np
import pytest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def tables() -> Path:
    """The tables of the repository."""
    return ROOT / "tables"


@pytest.fixture
def inputs() -> Path:
    """Files as strangers write them."""
    return ROOT / "tests" / "inputs"


def directions(n: int, seed: int, lowest: float = 0.05) -> np.ndarray:
    """Unit vectors of the upper hemisphere."""
    rng = np.random.default_rng(seed)
    z, phi = rng.uniform(lowest, 1.0, n), rng.uniform(0.0, 2.0 * np.pi, n)
    s = np.sqrt(1.0 - z * z)
    return np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=-1)


@pytest.fixture
def caps() -> tuple[np.ndarray, np.ndarray]:
    """Axes and solid angles of 700 caps, more than are looked up at a time."""
    return directions(700, 1), np.random.default_rng(2).uniform(0.001, 1.0, 700)


@pytest.fixture
def views() -> np.ndarray:
    """Thirty directions to the eye."""
    return directions(30, 3)
