#!/usr/bin/env python3
"""Writes the files of measured data under valid/measured and invalid/measured, of a material of known formula.

Usage: make_measured.py [DIRECTORY], the folder of this script by default. Needs numpy. Prints the albedos that expected.toml
states. `merl`, `cornell`, `csv` and `rgl` are also what tests/peers/mitsuba_measured.py and others write with.
"""

import pathlib
import struct
import sys

import numpy as np

SCALE = (1 / 1500, 1.15 / 1500, 1.66 / 1500)


def spherical(theta, phi):
    theta, phi = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def ggx(alpha, f0, kd):
    """f_r of kd/pi + D F G1 G1 / (4 cos cos) with Schlick's reflectance, RGB, of arrays of directions."""
    f0, kd = np.broadcast_to(np.asarray(f0, float), 3), np.broadcast_to(np.asarray(kd, float), 3)

    def f(wi, wo):
        h = wi + wo
        h = h / np.maximum(np.linalg.norm(h, axis=-1, keepdims=True), 1e-12)
        d = alpha**2 / (np.pi * ((alpha**2 - 1) * h[..., 2] ** 2 + 1) ** 2)
        over = lambda z: 2 / (z + np.sqrt(z**2 + alpha**2 * (1 - z**2)))
        cos = np.clip((wi * h).sum(-1), 0, 1)[..., None]
        fresnel = f0 + (1 - f0) * (1 - cos) ** 5
        return kd / np.pi + fresnel * (d * over(wi[..., 2]) * over(wo[..., 2]) / 4)[..., None]

    return f


def brushed(alpha_x, alpha_y, f0):
    """f_r of anisotropic GGX facets with Schlick's reflectance, RGB."""
    f0 = np.broadcast_to(np.asarray(f0, float), 3)

    def f(wi, wo):
        h = wi + wo
        h = h / np.maximum(np.linalg.norm(h, axis=-1, keepdims=True), 1e-12)
        stretched = (h[..., 0] / alpha_x) ** 2 + (h[..., 1] / alpha_y) ** 2 + h[..., 2] ** 2
        d = 1 / (np.pi * alpha_x * alpha_y * stretched**2)
        over = lambda w: 2 / (w[..., 2] + np.sqrt(w[..., 2] ** 2 + (alpha_x * w[..., 0]) ** 2 + (alpha_y * w[..., 1]) ** 2))
        cos = np.clip((wi * h).sum(-1), 0, 1)[..., None]
        fresnel = f0 + (1 - f0) * (1 - cos) ** 5
        return fresnel * (d * over(wi) * over(wo) / 4)[..., None]

    return f


def merl(path, f, bins=(90, 90, 180)):
    """MERL: values at the middles of the bins, -1 below the horizon."""
    middle = lambda n: (np.arange(n) + 0.5) / n
    h = (middle(bins[0]) ** 2 * np.pi / 2)[:, None, None]
    d = (middle(bins[1]) * np.pi / 2)[None, :, None]
    p = (middle(bins[2]) * np.pi)[None, None, :]
    h, d, p = np.broadcast_arrays(h, d, p)
    half = np.stack([np.sin(h), 0 * h, np.cos(h)], -1)
    across = np.stack([np.cos(h) * np.cos(p), np.sin(p), -np.sin(h) * np.cos(p)], -1)
    wi = np.cos(d)[..., None] * half + np.sin(d)[..., None] * across
    wo = np.cos(d)[..., None] * half - np.sin(d)[..., None] * across
    lit = (wi[..., 2] > 0) & (wo[..., 2] > 0)
    with np.errstate(all="ignore"):
        values = f(wi, wo)
    with open(path, "wb") as file:
        file.write(struct.pack("<3i", *bins))
        for c in range(3):
            file.write(np.where(lit, values[..., c] / SCALE[c], -1.0).astype("<f8").tobytes())


def pairs(zeniths, azimuths):
    i, o, p = np.meshgrid(zeniths, zeniths, azimuths, indexing="ij")
    return i.ravel(), o.ravel(), p.ravel()


def csv(path, f, zeniths, azimuths):
    """CSV in degrees."""
    i, o, p = pairs(zeniths, azimuths)
    rgb = f(spherical(np.radians(i), 0), spherical(np.radians(o), np.radians(p)))
    with open(path, "w") as file:
        file.write("# made by make_measured.py\ntheta_i_deg,theta_o_deg,phi_deg,r,g,b\n")
        for row in zip(i, o, p, *rgb.T):
            file.write(",".join(f"{x:.6g}" for x in row) + "\n")


def cornell(path, f, zeniths, azimuths):
    """Cornell's text: a grey material, 31 wavelengths alike."""
    i, o, p = (np.radians(x) for x in pairs(zeniths, azimuths))
    values = f(spherical(i, 0), spherical(o, p))[:, 0]
    with open(path, "w") as file:
        file.write("# made by make_measured.py\n\n# num wls\n31\n\n# wls\n")
        file.write(" ".join(str(400 + 10 * k) for k in range(19)) + "\n")
        file.write(" ".join(str(590 + 10 * k) for k in range(12)) + "\n\n# theta i  phi i  theta s  phi_s  values\n\n")
        for a, b, c, v in zip(i, o, p, values):
            file.write(f"{a:.6f} 0.000000 {b:.6f} {c:.6f} " + " ".join([f"{v:.6f}"] * 31) + "\n")


def tensors(path, fields):
    """A tensor file of numpy arrays: single precision, or bytes."""
    head = 12 + 2 + 4 + sum(2 + len(name) + 2 + 1 + 8 + 8 * a.ndim for name, a in fields.items())
    offset, table, body = head, b"", b""
    for name, a in fields.items():
        kind = {"float32": 10, "uint8": 1}[str(a.dtype)]
        table += struct.pack("<H", len(name)) + name.encode() + struct.pack("<HBQ", a.ndim, kind, offset + len(body))
        table += struct.pack(f"<{a.ndim}Q", *a.shape)
        body += a.tobytes()
    pathlib.Path(path).write_bytes(b"tensor_file\0" + bytes([1, 0]) + struct.pack("<I", len(fields)) + table + body)


def rgl(path, f, zeniths, size=(16, 16), azimuths=(0.0,), wavelengths=None):
    """RGL's parametrisation of f with a uniform density of visible normals: then S is f cos itself at each half vector."""
    columns, rows = size
    theta_m = (np.arange(columns) / (columns - 1)) ** 2 * np.pi / 2
    phi_m = (2 * np.arange(rows) / (rows - 1) - 1) * np.pi
    theta_m, phi_m = np.meshgrid(theta_m, phi_m)
    views = (len(azimuths), len(zeniths))
    spectra = np.zeros((*views, 3, rows, columns), "f4")
    for a, azimuth in enumerate(azimuths):
        for z, zenith in enumerate(zeniths):
            wo = spherical(zenith, azimuth)
            m = spherical(theta_m, phi_m + (azimuth if len(azimuths) <= 2 else 0))
            wi = 2 * (m @ wo)[..., None] * m - wo
            lit = wi[..., 2] > 0
            value = f(np.where(lit[..., None], wi, [0, 0, 1]), np.broadcast_to(wo, wi.shape)) * np.abs(wi[..., 2:])
            spectra[a, z] = np.moveaxis(np.where(lit[..., None], value, 0), -1, 0)
    # Mitsuba asks for as many nodes of the luminance as of the spectra, as many in rows as in columns.
    flat = lambda *size: np.ones((*views, *size), "f4")
    fields = {
        "description": np.frombuffer(b"made by make_measured.py", "u1"),
        "jacobian": np.array([1], "u1"),
        "phi_i": np.array(azimuths, "f4"),
        "theta_i": np.array(zeniths, "f4"),
        "ndf": np.ones((4, 4), "f4"),
        "sigma": np.full((4, 4), 0.25, "f4"),
        "vndf": flat(4, 4),
        "luminance": flat(rows, columns),
    }
    if wavelengths is None:
        fields["rgb"] = spectra
    else:
        fields["wavelengths"] = np.array(wavelengths, "f4")
        fields["spectra"] = np.repeat(spectra[:, :, :1], len(wavelengths), axis=2)
    tensors(path, fields)


def albedo(f, theta, azimuth=0.0):
    """Integral of f cos over the hemisphere of wi, by Gauss and the trapezoid rule in cos and azimuth."""
    x, w = np.polynomial.legendre.leggauss(400)
    z, w = 0.5 * (x + 1), 0.5 * w
    phi = 2 * np.pi * (np.arange(800) + 0.5) / 800
    wi = spherical(np.arccos(z)[:, None], phi[None, :])
    wo = np.broadcast_to(spherical(theta, azimuth), wi.shape)
    return (f(wi, wo) * (z * w * 2 * np.pi / 800)[:, None, None]).sum((0, 1))


def damaged(folder):
    """Files that are refused."""
    f = ggx(0.5, 0.5, 0.1)
    merl(folder / "good.binary", f, (4, 4, 4))
    good = (folder / "good.binary").read_bytes()
    (folder / "good.binary").unlink()
    files = {
        "short.binary": good[:700],
        "head.binary": good[:5],
        "huge.binary": struct.pack("<3i", 90, 90, 2_000_000_000) + good[12:],
        "negative.binary": struct.pack("<3i", -4, 4, 4) + good[12:],
        "dimensions.binary": struct.pack("<3i", 4, 4, 5) + good[12:],
        "nan.binary": good[:28] + struct.pack("<d", float("nan")) + good[36:],
        "zero.binary": good[:12] + bytes(len(good) - 12),
    }
    rgl(folder / "good.bsdf", f, (0.0, 0.8, 1.5), (4, 4))
    good = (folder / "good.bsdf").read_bytes()
    (folder / "good.bsdf").unlink()
    at = good.index(b"vndf")
    files |= {
        "short.bsdf": good[:-40],
        "magic.bsdf": b"x" + good[1:],
        "version.bsdf": good[:12] + bytes([9, 9]) + good[14:],
        "huge.bsdf": good[: at + 15] + struct.pack("<Q", 1 << 60) + good[at + 23 :],
        "missing.bsdf": good.replace(b"sigma", b"sigmb"),
        "nan.bsdf": good[:-4] + struct.pack("<f", float("nan")),
        "words.csv": b"theta_i,theta_o,phi,r,g,b\n0.1,0.2,0.3,0.1,0.1,red\n",
        "columns.csv": b"theta_i,theta_o,r,g,b\n0.1,0.2,0.1,0.1,0.1\n",
        "horizon.csv": b"theta_i_deg,theta_o,phi,r,g,b\n91,0.2,0.3,0.1,0.1,0.1\n",
        "few.csv": b"theta_i,theta_o,phi,r,g,b\n0.1,0.2,0.3,0.1,0.1,0.1\n",
        "faint.csv": b"theta_i,theta_o,phi,r,g,b\n"
        + b"".join(b"0.%d,0.2,%d,1e-300,1e-300,1e-300\n" % (i, i % 3) for i in range(1, 9)),
        "short.brdf": b"# num wls\n2\n# wls\n500 600\n0.1 0 0.2 0 0.1\n",
        "waves.brdf": b"3\n500 600\n",
        "data.txt": b"0.1\n",
    }
    for name, content in files.items():
        (folder / name).write_bytes(content)


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent)
    valid, invalid = folder / "valid" / "measured", folder / "invalid" / "measured"
    for made in (valid, invalid):
        made.mkdir(parents=True, exist_ok=True)
    satin = ggx(0.5, (0.9, 0.6, 0.3), (0.05, 0.1, 0.2))
    grey = ggx(0.4, 0.3, 0.2)
    merl(valid / "satin.binary", satin, (24, 12, 12))
    zeniths, azimuths = np.arange(0, 90, 12), np.arange(0, 181, 20)
    csv(valid / "satin.csv", satin, zeniths, azimuths)
    cornell(valid / "grey.brdf", grey, np.arange(8, 90, 16), np.arange(0, 181, 30))
    rgl(valid / "satin.bsdf", satin, np.radians(np.arange(0, 90, 12.8)), (16, 16))
    rgl(valid / "spectral.bsdf", grey, np.radians(np.arange(0, 90, 17.8)), (12, 12), wavelengths=(400, 550, 700))
    for degrees in (0, 60):
        print(degrees, "satin", albedo(satin, np.radians(degrees)), "grey", albedo(grey, np.radians(degrees)))
    # A quarter of the azimuths: it is the same mirrored at both axes.
    metal = brushed(0.3, 0.8, (0.9, 0.7, 0.4))
    rgl(valid / "brushed.bsdf", metal, np.radians(np.arange(0, 90, 12.8)), (14, 14), np.linspace(-np.pi, -np.pi / 2, 5))
    for degrees in (20, 70):
        print("brushed, seen at 60 degrees from an azimuth of", degrees, albedo(metal, np.pi / 3, np.radians(degrees)))
    damaged(invalid)


if __name__ == "__main__":
    main()
