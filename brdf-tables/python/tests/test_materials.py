"""Materials, files and fits."""

import os
import signal
import threading
import time

import brdf_tables as bt
import numpy as np
import pytest


def test_recipes(tables):
    material = bt.Material("ggx:alpha=0.1,f0=0.04,kd=0.3")
    assert (material.model, material.kd, material.ks) == ("ggx", [0.3] * 3, [1.0] * 3)
    assert bt.Material(material.recipe) == material == bt.Material(material)
    assert material.is_isotropic and not bt.Material(tables / "ward-0.1-0.5.toml").is_isotropic
    assert set(bt.families()) >= {"phong", "ggx", "beckmann", "sheen"}
    assert bt.Table.of_family("lafortune:lobes=[[-1,-1,1,20]]") is None


def test_eval():
    material = bt.Material("phong:exponent=10,kd=0.5,ks=0.5")
    wi = np.array([[0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [0.0, 0.6, -0.8]])
    found = material.eval(wi, [-0.6, 0.0, 0.8])
    expected = 0.5 / np.pi + 0.5 * 12 / (2 * np.pi) * np.array([1.0, 0.8**10])
    assert found.shape == (3, 3) and np.allclose(found[:2, 1], expected) and not found[2].any()
    assert material.eval(wi[:, None], wi[:2]).shape == (3, 2, 3)
    with pytest.raises(bt.BrdfTablesError, match="do not fit"):
        material.eval(wi, wi[:2])


@pytest.mark.parametrize(
    ("recipe", "words"),
    [
        ("ggx:alpha=9", "item 1"),
        ("ggx:alpha=0.1,shine=2", 'unknown key "shine"'),
        ("phong", "nor is there a file of this name"),
        ("velvet:alpha=1", "unknown model"),
    ],
)
def test_bad_recipes(recipe, words):
    for use in (bt.Material, bt.fit, bt.Table.of_family):
        with pytest.raises(bt.BrdfTablesError) as error:
            use(recipe)
        assert words in str(error.value) and "\n" not in str(error.value)


def test_bad_files(tables, tmp_path):
    for use in (bt.Material, bt.Table.load):
        for name in ("none.toml", "none.binary"):
            with pytest.raises(FileNotFoundError, match=name):
                use(tmp_path / name)
    damaged = bytearray((tables / "ggx-0.1.tbl").read_bytes())
    damaged[-9] ^= 1
    (tmp_path / "damaged.tbl").write_bytes(damaged)
    with pytest.raises(bt.BrdfTablesError, match="damaged.tbl: damaged: checksum"):
        bt.Table.load(tmp_path / "damaged.tbl")
    with pytest.raises(bt.BrdfTablesError):
        bt.Table.from_bytes(b"")
    with pytest.raises(OSError, match="nowhere"):
        bt.Table.load(tables / "ggx-0.1.tbl").save(tmp_path / "nowhere" / "a.tbl")
    with pytest.raises(TypeError):
        bt.Material(7)


def test_measured_data(inputs):
    material = bt.Material(inputs / "valid" / "measured" / "satin.csv")
    assert any("kept as" in note for note in material.notes)
    assert material.eval([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]).min() > 0.0


def test_fits_as_the_command(tables):
    """The same as the shipped table but for the line that says who made it."""
    seen = []
    fitted = bt.fit(tables / "phong-100.toml", progress=seen.append)
    shipped = bt.Table.load(tables / "phong-100.tbl")
    ours, theirs = fitted.info(), shipped.info()
    for key in ("material", "representation", "promise", "off_nodes", "seed"):
        assert ours[key] == theirs[key], key
    assert ours["command"].startswith("brdf_tables.fit(") and "seed=1" in ours["command"]
    assert seen == sorted(seen) and 0.0 <= seen[0] and seen[-1] == 1.0
    assert bt.fit(tables / "phong-100.toml", threads=1) == fitted


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"tolerance": 0.0}, "tolerance 0"),
        ({"representation": "lobe"}, "unknown representation"),
        ({"solver": "magic"}, "magic"),
        ({"lobes": 99}, "99 lobes"),
        ({"lobes": 2, "representation": "cubature"}, "lobes has no use with representation cubature"),
        ({"threads": 0}, "0 threads"),
        ({"representation": "zonal"}, "radial"),
    ],
)
def test_bad_options(options, words):
    with pytest.raises(bt.BrdfTablesError, match=words):
        bt.fit("ward:alpha_x=0.1,alpha_y=0.5", **options)


def test_progress_may_stop_a_fit():
    def stop(fraction):
        raise RuntimeError(f"enough at {fraction}")

    start = time.perf_counter()
    with pytest.raises(RuntimeError, match="enough"):
        bt.fit("ward:alpha_x=0.1,alpha_y=0.5", progress=stop)
    assert time.perf_counter() - start < 5.0


@pytest.mark.skipif(not hasattr(signal, "pthread_kill"), reason="signals of this system are others")
@pytest.mark.parametrize(
    "work",
    [
        lambda: bt.fit("ward:alpha_x=0.05,alpha_y=0.5", representation="lobes"),
        lambda: bt.monte_carlo("ggx:alpha=0.1", np.tile([0.6, 0.0, 0.8], (10**6, 1)), 0.1, [-0.6, 0.0, 0.8], samples=1024),
    ],
)
def test_ctrl_c_is_heard(work):
    # Where the tests run in the background of a shell, the signal is ignored unless it is asked for.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        start = time.perf_counter()
        with pytest.raises(KeyboardInterrupt):
            work()
        assert time.perf_counter() - start < 8.0
    finally:
        signal.signal(signal.SIGINT, before)
