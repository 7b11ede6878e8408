"""A glossy floor under spherical lamps, without noise and without a ray: `python area_lights.py [PICTURE.png]`.

A spherical lamp fills a cap of directions exactly, and is equally bright all over: what the floor reflects of it is
L = radiance * (projected solid angle) * (mean BRDF over the cap). The picture is checked against Monte Carlo at some pixels.
"""

import sys
import time

import brdf_tables
import matplotlib.image
import numpy as np

WIDTH, HEIGHT = 480, 270
EYE, UP, LOOK = np.array([0.0, -6.0, 1.6]), np.array([0.0, 0.0, 1.0]), np.array([0.0, 2.0, -0.4])
FLOOR = "ggx:alpha=0.12,f0=0.06,kd=[0.05,0.06,0.08]"
# Centre, radius, radiance.
LAMPS = [
    ([-1.8, 0.5, 0.6], 0.30, [9.0, 3.0, 1.5]),
    ([0.0, 1.5, 1.0], 0.60, [1.6, 2.0, 2.4]),
    ([1.9, 0.2, 0.4], 0.20, [2.0, 9.0, 4.0]),
    ([0.9, -2.0, 0.15], 0.08, [20.0, 14.0, 8.0]),
]


def normalised(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def camera_rays() -> np.ndarray:
    """Directions of the rays through the middles of the pixels (height, width, 3)."""
    forward = normalised(LOOK - EYE)
    right = normalised(np.cross(forward, UP))
    up = np.cross(right, forward)
    x = ((np.arange(WIDTH) + 0.5) / WIDTH - 0.5) * 0.9
    y = (0.5 - (np.arange(HEIGHT) + 0.5) / HEIGHT) * 0.9 * HEIGHT / WIDTH
    return normalised(forward + x[None, :, None] * right + y[:, None, None] * up)


def caps_of(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lamps as seen from points of the floor: axes (..., lamps, 3), solid angles (..., lamps), radiances (lamps, 3)."""
    centre, radius, radiance = (np.array(column) for column in zip(*LAMPS))
    way = centre - points[..., None, :]
    distance = np.linalg.norm(way, axis=-1)
    solid_angle = 2.0 * np.pi * (1.0 - np.sqrt(1.0 - (radius / distance) ** 2))
    return way / distance[..., None], solid_angle, radiance


def picture() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Radiance of every pixel, where it sees the floor, and which pixels do."""
    rays = camera_rays()
    image = 0.02 * np.ones((HEIGHT, WIDTH, 3)) * (1.0 - np.abs(rays[..., 2:]))
    floor = rays[..., 2] < -1e-3
    points = EYE + rays[floor] * (-EYE[2] / rays[floor][:, 2:])
    table = brdf_tables.Table.of_family(FLOOR)
    axis, solid_angle, radiance = caps_of(points)
    # All lamps of a pixel are seen from one direction: they are looked up together.
    mean = table.rgb(axis, solid_angle, -rays[floor][:, None, :])
    irradiance = brdf_tables.projected_solid_angle(axis, solid_angle)
    image[floor] = np.einsum("plc,pl,lc->pc", mean, irradiance, radiance)
    # The lamps themselves, from the farthest to the nearest.
    for centre, radius, radiance in sorted(LAMPS, key=lambda lamp: -np.linalg.norm(np.array(lamp[0]) - EYE)):
        along = (np.array(centre) - EYE) @ np.moveaxis(rays, -1, 0).reshape(3, -1)
        away = np.linalg.norm(EYE + along[:, None] * rays.reshape(-1, 3) - np.array(centre), axis=-1)
        image.reshape(-1, 3)[away < radius] = radiance
    return image, points, np.argwhere(floor)


def errors_of(image: np.ndarray, points: np.ndarray, pixels: np.ndarray, count: int = 100) -> np.ndarray:
    """Differences from Monte Carlo at some pixels that show the floor, over the brightest of them."""
    lamps = [radiance for _, _, radiance in LAMPS]
    shown = np.flatnonzero([not any(np.array_equal(image[tuple(p)], lamp) for lamp in lamps) for p in pixels])
    chosen = np.random.default_rng(1).choice(shown, count, replace=False)
    axis, solid_angle, radiance = caps_of(points[chosen])
    wo = normalised(EYE - points[chosen])
    mean, _ = brdf_tables.monte_carlo(FLOOR, axis, solid_angle, wo[:, None, :], samples=16384)
    irradiance = brdf_tables.projected_solid_angle(axis, solid_angle)
    truth = np.einsum("plc,pl,lc->pc", mean, irradiance, radiance)
    return np.abs(image[tuple(pixels[chosen].T)] - truth).max(axis=-1) / truth.max()


def main() -> None:
    path = sys.argv[1] if len(sys.argv) > 1 else "area_lights.png"
    start = time.perf_counter()
    image, points, pixels = picture()
    seconds = time.perf_counter() - start
    encoded = np.clip(image / (1.0 + 0.3 * image), 0.0, 1.0) ** (1.0 / 2.2)
    matplotlib.image.imsave(path, encoded)
    errors = errors_of(image, points, pixels)
    print(f"{path}: {len(points) * len(LAMPS)} caps of {len(points)} pixels in {seconds:.2f} s")
    # Tables hold what they promise for caps of up to 2.5 lobe widths; those of a lamp near the floor are wider.
    usual, worst = 100 * np.quantile(errors, 0.95), 100 * errors.max()
    print(f"from Monte Carlo, percent of the brightest of {len(errors)} pixels: 95 of 100 within {usual:.3f}, all within {worst:.2f}")
    if usual > 0.5:
        sys.exit("the table or the picture is wrong")


if __name__ == "__main__":
    main()
