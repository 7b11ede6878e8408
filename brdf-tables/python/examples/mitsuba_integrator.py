"""An integrator of Mitsuba 3 that lights surfaces by tables: `pip install mitsuba pillow`, then
`python mitsuba_integrator.py [PICTURE.png]`.

Spherical lamps are caps of directions, of even radiance: what a surface reflects of each is L = E * F, with the irradiance E of
the cap and the mean BRDF F of a table, without a sample of the lamp. One shadow ray to the middle of each lamp says whether it
is seen. Mitsuba's path tracer, at the same number of camera rays and at many more, shows what that is worth: the picture has
the integrator's on the left, the path tracer's at equal rays in the middle, at many on the right.
"""

import sys
import time

import brdf_tables
import mitsuba as mi
import numpy as np

try:
    mi.set_variant("llvm_ad_rgb")
    import drjit as dr

    dr.eval(mi.Float(1.0) + 1.0)
except Exception as error:
    sys.exit(f"the variant llvm_ad_rgb of Mitsuba does not run here (is LLVM installed?): {error}")

RAYS, MANY = 16, 1024
# What each surface is made of, as Mitsuba and as a recipe of ours.
MATERIALS = {
    "floor": ({"type": "roughconductor", "distribution": "ggx", "alpha": 0.15, "material": "none"}, "ggx:alpha=0.15"),
    "wall": ({"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.5, 0.45, 0.4]}}, "lambert:reflectance=[0.5,0.45,0.4]"),
    "side": ({"type": "roughconductor", "distribution": "beckmann", "alpha": 0.3, "material": "none"}, "beckmann:alpha=0.3"),
}
# Centre, radius, radiance.
LAMPS = [([-1.0, 0.8, 0.3], 0.25, [6.0, 3.0, 1.5]), ([0.7, 0.5, 0.0], 0.15, [2.0, 6.0, 9.0]), ([0.2, 1.5, -0.4], 0.3, [4.0, 4.0, 4.0])]


def scene() -> mi.Scene:
    to = mi.ScalarTransform4f
    places = {
        "floor": to().rotate([1, 0, 0], -90).scale(2.0),
        "wall": to().translate([0, 2, -1.5]).scale(2.0),
        "side": to().translate([2, 2, 0]).rotate([0, 1, 0], -90).scale(2.0),
    }
    parts = {
        name: {"type": "rectangle", "to_world": places[name], "bsdf": {**bsdf, "id": f"{name} surface"}}
        for name, (bsdf, _) in MATERIALS.items()
    }
    for i, (centre, radius, radiance) in enumerate(LAMPS):
        emitter = {"type": "area", "radiance": {"type": "rgb", "value": radiance}}
        parts[f"lamp{i}"] = {"type": "sphere", "center": centre, "radius": radius, "emitter": emitter}
    film = {"type": "hdrfilm", "width": 320, "height": 240, "rfilter": {"type": "box"}}
    eye = to().look_at(origin=[-0.8, 1.3, 3.6], target=[0.2, 0.7, 0.0], up=[0, 1, 0])
    sensor = {"type": "perspective", "fov": 50, "to_world": eye, "film": film}
    return mi.load_dict({"type": "scene", "sensor": sensor, **parts})


class Tables(mi.SamplingIntegrator):
    """Emission, and direct light of spherical lamps by tables."""

    def __init__(self, properties: mi.Properties) -> None:
        super().__init__(properties)
        self.tables = {}
        for name, (_, recipe) in MATERIALS.items():
            self.tables[name] = brdf_tables.Table.of_family(recipe) or brdf_tables.fit(recipe)

    def sample(self, scene, sampler, ray, medium=None, active=True):
        hit = scene.ray_intersect(ray, active)
        radiance = np.array(hit.emitter(scene).eval(hit, active)).T
        wo = np.array(hit.wi).T
        axis, solid_angle, seen = (np.stack(parts, axis=1) for parts in zip(*(self.lamp(scene, hit, *lamp[:2]) for lamp in LAMPS)))
        emitted = np.array([radiance for _, _, radiance in LAMPS])
        for name, here in self.surfaces(scene, hit).items():
            # Surfaces seen from behind are left out. All lamps of a point are seen from one direction: looked up together.
            at = here & (wo[:, 2] > 1e-4)
            mean = self.tables[name].rgb(axis[at], solid_angle[at], wo[at][:, None, :])
            irradiance = brdf_tables.projected_solid_angle(axis[at], solid_angle[at]) * seen[at]
            radiance[at] += np.einsum("plc,pl,lc->pc", mean, irradiance, emitted)
        return mi.Color3f(radiance.T.astype(np.float32)), hit.is_valid(), []

    def lamp(self, scene, hit, centre, radius) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A lamp as a cap in the frames of the surfaces: axes, solid angles, and whether it is seen."""
        way = mi.Point3f(*centre) - hit.p
        distance = dr.norm(way)
        # The shadow ray ends at the surface of the lamp.
        shadow = hit.spawn_ray_to(hit.p + way * (1.0 - 1.001 * radius / distance))
        axis = np.array(hit.to_local(way / distance)).T
        # Lamps whose middle is below the horizon are left out; what stands in their place is not counted.
        seen = ~np.array(scene.ray_test(shadow, hit.is_valid())) & (axis[:, 2] > 0.0)
        axis[~seen] = [0.0, 0.0, 1.0]
        share = np.minimum(radius / np.array(distance), 1.0)
        return axis, 2.0 * np.pi * (1.0 - np.sqrt(1.0 - share**2)), seen

    def surfaces(self, scene, hit) -> dict[str, np.ndarray]:
        """Where each material was hit."""
        shapes = {shape.bsdf().id(): shape for shape in scene.shapes() if not shape.is_emitter()}
        valid = np.array(hit.is_valid())
        return {name: valid & np.array(hit.shape == mi.ShapePtr(shapes[f"{name} surface"])) for name in MATERIALS}


def rmse(image: np.ndarray, truth: np.ndarray) -> float:
    return float(np.sqrt(np.mean((image - truth) ** 2)))


def main() -> None:
    path = sys.argv[1] if len(sys.argv) > 1 else "mitsuba_integrator.png"
    mi.register_integrator("tables", Tables)
    view = scene()
    direct = {"type": "path", "max_depth": 2}
    pictures, seconds = [], []
    for integrator, rays, seed in (({"type": "tables"}, RAYS, 1), (direct, RAYS, 1), (direct, MANY, 2)):
        start = time.perf_counter()
        pictures.append(np.array(mi.render(view, integrator=mi.load_dict(integrator), spp=rays, seed=seed))[..., :3])
        seconds.append(time.perf_counter() - start)
    ours, theirs, truth = pictures
    both = np.clip(np.concatenate(pictures, axis=1), 0.0, 1.0) ** (1.0 / 2.2)
    mi.Bitmap((255.0 * both + 0.5).astype(np.uint8)).write(path)
    bias = ours.mean() / truth.mean() - 1.0
    print(f"{path}: tables {seconds[0]:.2f} s, path tracer {seconds[1]:.2f} s, both with {RAYS} rays a pixel")
    print(f"rmse against {MANY} rays: tables {rmse(ours, truth):.4f}, path tracer {rmse(theirs, truth):.4f}; bias {100 * bias:.2f} %")
    if abs(bias) > 0.02 or rmse(ours, truth) > rmse(theirs, truth):
        sys.exit("the tables are wrong, or of no use")


if __name__ == "__main__":
    main()
