"""Why pictures with `roughplastic` differ from Mitsuba's by up to a percent: its internal reflectance.

The diffuse base of a rough coat returns kd / (1 - kd rho) with rho the share of diffuse light that the coat sends back.
Mitsuba 3 sums 64 nodes of the cosine, both ends with full weight, which gives 1.5 % less than the integral. Reads rho off
two evaluations of Mitsuba's model and compares it with the closed form (Egan and Hilgeman 1973) and with that sum.

  python tests/peers/mitsuba_rough_plastic.py
"""

import sys

try:
    import drjit as dr
    import mitsuba as mi
    import numpy as np

    mi.set_variant("llvm_ad_rgb")
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(0)

ETA = 1.5


def evaluate(albedo):
    """f_r cos of the diffuse part at one pair of directions."""
    colour = lambda value: {"type": "rgb", "value": value}
    bsdf = mi.load_dict({
        "type": "roughplastic", "distribution": "ggx", "alpha": 0.01, "int_ior": ETA, "ext_ior": 1.0,
        "nonlinear": True, "diffuse_reflectance": colour(albedo), "specular_reflectance": colour(0.0),
    })
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = mi.Vector3f(0.6, 0.0, 0.8)
    return float(np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(0.0, 0.6, 0.8)))[0].ravel()[0])


def fresnel(cosine):
    """Reflectance of the coat seen from within."""
    sine2 = (1 - cosine**2) * ETA**2
    other = np.sqrt(np.maximum(0, 1 - sine2))
    s = (ETA * cosine - other) / (ETA * cosine + other)
    p = (cosine - ETA * other) / (cosine + ETA * other)
    return np.where(sine2 < 1, 0.5 * (s**2 + p**2), 1.0)


low, high = 0.2, 0.8
a, b = evaluate(low) / low, evaluate(high) / high
found = (b - a) / (high * b - low * a)
middle = (np.arange(1_000_000) + 0.5) / 1e6
exact = 2 * np.mean(fresnel(middle) * middle)
nodes = np.maximum(1e-6, np.linspace(0, 1, 64))
summed = 2 * np.mean(fresnel(nodes) * nodes)
print(f"internal reflectance at index {ETA}: Mitsuba {found:.4f}, sum of 64 nodes {summed:.4f}, integral {exact:.4f}")
explained = abs(found - summed) < 0.002 and exact - found > 0.005
print("explained" if explained else "NOT explained: Mitsuba's sum is not what it was")
sys.exit(0 if explained else 1)
