"""The mean BRDF of a material over spherical caps, looked up from small fitted tables.

A light that fills a cap of directions and gives a point the irradiance E is reflected to the eye as L = E * F, where F is the
mean of the BRDF over the cap, weighted by the cosine and clipped by the horizon ("A Radiance Cache Method for Highly Glossy
Surfaces", 2015, eqs. 8 and 9)::

    import brdf_tables, numpy as np

    table = brdf_tables.Table.of_family("ggx:alpha=0.1")    # or Table.load("gold.tbl"), or fit("gold.binary")
    axis = np.array([[0.6, 0.0, 0.8], [0.0, 0.8, 0.6]])     # caps, in the local frame: z is the normal
    omega = np.array([0.10, 0.05])                          # their solid angles, sr
    F = table.specular(axis, omega, [-0.6, 0.0, 0.8])       # 1/sr, one per cap

Shapes broadcast as numpy's do: ``axis`` (..., 3), ``solid_angle`` (...), ``wo`` (..., 3). ``float32`` and ``float64`` arrays
are read where they lie, in any order of memory, and the interpreter's lock is released while numbers are computed. Caps that
are seen from one direction are looked up together, several times as fast as pairs one by one: give ``axis`` as (1, n, 3) and
``wo`` as (m, 1, 3) for all n caps from all m directions.

All directions are unit vectors away from the surface, angles in radian, solid angles in sr. What is outside of the domain is
an error, :class:`BrdfTablesError`, whose one line says what and where.
"""

from ._native import (
    BrdfTablesError,
    Material,
    Table,
    __version__,
    families,
    fit,
    integrate,
    monte_carlo,
    projected_solid_angle,
)

__all__ = [
    "BrdfTablesError",
    "Material",
    "Table",
    "__version__",
    "families",
    "fit",
    "integrate",
    "monte_carlo",
    "projected_solid_angle",
]
