"""The look-up: values, shapes, memory, errors."""

import pickle
import threading
import time

import brdf_tables as bt
import numpy as np
import pytest

RECIPES = ["phong:exponent=100", "ggx:alpha=0.2,f0=0.04,kd=0.3", "ward:alpha_x=0.1,alpha_y=0.3", "sheen:alpha=0.5"]


@pytest.mark.parametrize("recipe", RECIPES)
def test_tables_are_what_integration_gives(recipe, caps, views):
    axis, omega = caps[0][:40], caps[1][:40]
    table = bt.Table.of_family(recipe)
    found = table.specular(axis, omega, views[:, None])
    exact = bt.integrate(recipe, axis, omega, views[:, None])
    assert found.shape == exact.shape == (30, 40) and found.dtype == np.float32 and exact.dtype == np.float64
    peak = exact.max(axis=0)
    assert np.abs(found - exact).max() < 0.03 * peak.max()
    assert np.median(np.abs(found - exact) / peak) < 0.002


def test_readme_of_the_library(tables):
    table = bt.Table.load(tables / "phong-100.tbl")
    value = table.specular([[0.6, 0.0, 0.8], [0.0, 0.8, 0.6]], [0.10, 0.05], [-0.6, 0.0, 0.8])
    assert abs(np.dot([2.0, 1.0], value) - 16.2) < 0.1


def test_every_shape_gives_the_same(caps, views):
    axis, omega = caps
    table = bt.Table.of_family("ggx:alpha=0.15")
    all_pairs = table.specular(axis, omega, views[:, None])
    assert all_pairs.shape == (30, 700)
    assert np.array_equal(table.specular(axis[:, None], omega[:, None], views), all_pairs.T)
    pairs = np.array([[table.specular(axis[i], omega[i], views[j]) for i in range(5)] for j in range(4)])
    # The last bits depend on how many caps share a vector.
    assert np.allclose(pairs, all_pairs[:4, :5], rtol=1e-5)
    one_by_one = table.specular(axis[:30], omega[:30], views)
    assert np.allclose(one_by_one, np.diagonal(all_pairs[:, :30]), rtol=1e-5)
    cube = table.specular(axis.reshape(7, 1, 100, 3), omega.reshape(7, 1, 100), views.reshape(1, 30, 1, 3))
    assert np.allclose(cube.transpose(1, 0, 2).reshape(30, 700), all_pairs, rtol=1e-5)
    assert table.specular(np.zeros((0, 3)), np.zeros(0), views[0]).shape == (0,)
    assert table.specular(axis[0], omega[0], views[0]).shape == ()


def test_memory_is_read_in_any_order(caps, views):
    axis, omega = caps
    table = bt.Table.of_family("phong:exponent=30")
    expected = table.specular(axis, omega, views[0])
    assert np.array_equal(table.specular(np.asfortranarray(axis), omega, views[0]), expected)
    # The last bits depend on which caps share a vector.
    assert np.allclose(table.specular(axis[::-1], omega[::-1], views[0])[::-1], expected, rtol=1e-5, atol=1e-9)
    single = table.specular(axis.astype(np.float32), omega.astype(np.float32), views[0].astype(np.float32))
    assert np.allclose(single, expected, rtol=1e-4, atol=1e-6)
    swapped = axis.astype(axis.dtype.newbyteorder())
    assert np.array_equal(table.specular(swapped, omega, views[0]), expected)
    unaligned = np.frombuffer(b"x" + axis.tobytes(), np.uint8)[1:].view(np.float64).reshape(axis.shape)
    assert not unaligned.flags.aligned
    assert np.array_equal(table.specular(unaligned, omega, views[0]), expected)
    frozen = axis.copy()
    frozen.flags.writeable = False
    assert np.array_equal(table.specular(frozen, omega, views[0]), expected)
    assert table.specular([0, 0, 1], 1, [0, 0, 1]).dtype == np.float32


def test_inputs_are_not_copied(caps):
    import tracemalloc

    axis = np.ascontiguousarray(np.broadcast_to(caps[0][0], (1_000_000, 3)))
    omega = np.full(1_000_000, 0.1)
    table = bt.Table.of_family("phong:exponent=30")
    tracemalloc.start()
    table.specular(axis, omega, [0.0, 0.0, 1.0])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # numpy counts what it allocates: neither of the 32 MB of the inputs.
    assert peak < 100_000


def test_rgb_has_diffuse_part_and_colours(caps, views):
    axis, omega = caps
    recipe = "ggx:alpha=0.2,f0=[0.9,0.5,0.2],kd=[0.1,0.2,0.3],ks=[1,0.5,0.25]"
    table = bt.Table.of_family(recipe)
    found, specular = table.rgb(axis, omega, views[0]), table.specular(axis, omega, views[0])
    assert found.shape == (700, 3)
    small = np.full(700, 1e-6)
    exact = bt.Material(recipe).eval(axis, views[0])
    assert np.allclose(table.rgb(axis, small, views[0]), exact, rtol=2e-3, atol=1e-4)
    rest = (found - np.array([0.1, 0.2, 0.3]) / np.pi) / np.array([1, 0.5, 0.25])
    assert np.all(rest[:, 0] >= rest[:, 1] - 1e-6) and np.all(specular > 0.0)
    matte = bt.fit("lambert:reflectance=[0.2,0.4,0.6]")
    assert matte.representation == "diffuse"
    assert np.allclose(matte.rgb(axis, omega, views[0]), np.array([0.2, 0.4, 0.6]) / np.pi)
    assert not matte.specular(axis, omega, views[0]).any()


def test_monte_carlo_agrees_with_its_error(caps, views):
    axis, omega = caps[0][:8], caps[1][:8]
    recipe = "beckmann:alpha=0.3,kd=0.2,ks=0.8"
    mean, error = bt.monte_carlo(recipe, axis, omega, views[0], samples=4096, seed=5)
    exact = 0.8 * bt.integrate(recipe, axis, omega, views[0]) + 0.2 / np.pi
    assert mean.shape == error.shape == (8, 3)
    assert np.all(np.abs(mean[:, 0] - exact) < 6.0 * error[:, 0] + 1e-9)
    again, _ = bt.monte_carlo(recipe, axis, omega, views[0], samples=4096, seed=5)
    assert np.array_equal(mean, again)


def test_projected_solid_angle():
    assert np.isclose(bt.projected_solid_angle([0.0, 0.0, 1.0], 2.0 * np.pi), np.pi)
    half = bt.projected_solid_angle([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], 1e-3)
    assert half.shape == (2,) and np.isclose(half[1], 1e-3, rtol=1e-3) and 0.0 < half[0] < 1e-4


@pytest.mark.parametrize(
    ("axis", "omega", "wo", "words"),
    [
        ([0.0, 0.0, 2.0], 1.0, [0, 0, 1], "not a unit vector"),
        ([0.6, 0.0, -0.8], 1.0, [0, 0, 1], "below the horizon"),
        ([0.0, 0.0, 1.0], 7.0, [0, 0, 1], "omega = 7 sr is outside (0, 2 pi]"),
        ([0.0, 0.0, 1.0], np.nan, [0, 0, 1], "omega = NaN"),
        ([0.0, 0.0, 1.0], 1.0, [0, 0, -1], "wo_z = -1 is not above the horizon"),
        ([0.0, 0.0, 1.0], 1.0, [0, 0, np.inf], "the length of wo is inf"),
        ([0.0, 1.0], 1.0, [0, 0, 1], "the last length must be 3"),
        (0.5, 1.0, [0, 0, 1], "the last length must be 3"),
        (np.ones((4, 3)), np.ones(5), [0, 0, 1], "do not fit"),
        (["a", "b", "c"], 1.0, [0, 0, 1], "axis: "),
        ([1j, 0, 0], 1.0, [0, 0, 1], "axis: "),
        ([[1, 0, 0], [1]], 1.0, [0, 0, 1], "axis: "),
    ],
)
def test_what_is_outside_is_refused(axis, omega, wo, words):
    table = bt.Table.of_family("phong:exponent=30")
    for ask in (table.specular, table.rgb, lambda *a: bt.integrate("phong:exponent=30", *a)):
        with pytest.raises(bt.BrdfTablesError) as error:
            ask(axis, omega, wo)
        assert words in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize("lengths", [(2**30, 2**30), (2**40, 2**40)])
def test_answers_that_no_memory_holds_are_refused(lengths):
    up = np.broadcast_to([0.0, 0.0, 1.0], (lengths[0], 1, 3)), np.broadcast_to([0.0, 0.0, 1.0], (lengths[1], 3))
    for ask in (bt.Table.of_family("phong:exponent=30").rgb, lambda *a: bt.integrate("phong:exponent=30", *a)):
        with pytest.raises(MemoryError, match="does not fit into memory"):
            ask(up[0], 1.0, up[1])
    with pytest.raises(MemoryError, match="does not fit into memory"):
        bt.Material("phong:exponent=30").eval(*up)


def test_nothing_asked_is_nothing_answered():
    table = bt.Table.of_family("phong:exponent=30")
    assert table.specular(np.zeros((0, 3)), 1.0, [0.0, 0.0, 1.0]).shape == (0,)
    assert table.rgb(np.zeros((4, 1, 3)), 1.0, np.zeros((0, 3))).shape == (4, 0, 3)


def test_errors_name_the_element(caps, views):
    axis, omega = caps
    omega = omega.copy()
    omega[650] = -1.0
    table = bt.Table.of_family("phong:exponent=30")
    with pytest.raises(bt.BrdfTablesError, match=r"^at \[0, 650\]: "):
        table.specular(axis, omega, views[:, None])
    with pytest.raises(bt.BrdfTablesError, match=r"^at \[650, 0\]: "):
        table.specular(axis[:, None], omega[:, None], views)


def test_the_lock_is_released(caps):
    """Another thread of Python goes on while a look-up runs."""
    axis = np.ascontiguousarray(np.tile(caps[0], (3000, 1)))
    omega = np.tile(caps[1], 3000)
    table = bt.Table.of_family("ggx:alpha=0.15")
    ticks, over = [], threading.Event()

    def tick():
        while not over.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    clock = threading.Thread(target=tick)
    clock.start()
    start = time.perf_counter()
    table.specular(axis, omega, [0.6, 0.0, 0.8])
    end = time.perf_counter()
    over.set()
    clock.join()
    within = [t for t in ticks if start < t < end]
    assert end - start < 0.02 or len(within) >= 5


def test_tables_are_values(tables, tmp_path):
    table = bt.Table.load(str(tables / "ggx-0.1.tbl"))
    assert pickle.loads(pickle.dumps(table)) == table
    table.save(tmp_path / "copy.tbl")
    assert (tmp_path / "copy.tbl").read_bytes() == (tables / "ggx-0.1.tbl").read_bytes() == table.to_bytes()
    assert table != bt.Table.load(tables / "ggx-0.3.tbl")
    assert table.material == bt.Material(table.material.recipe)
    info = table.info()
    assert info["representation"] == table.representation == "cubature" and info["promise"]["p95"] < 0.02
    assert info["off_nodes"]["worst"]["rmse_lobe"] <= info["promise"]["worst"] and info["off_nodes"]["caps"] == 100
    assert "ggx" in repr(table)
