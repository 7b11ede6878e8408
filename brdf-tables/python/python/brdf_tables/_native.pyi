"""Types of the module that is written in Rust."""

from collections.abc import Callable
from os import PathLike
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Recipe: TypeAlias = Material | str | PathLike[str]
"""A material; an inline recipe such as ``ggx:alpha=0.1,f0=0.04``; or the name of a TOML recipe or of measured data."""

__version__: str

class BrdfTablesError(ValueError):
    """Bad input; the message is the line that the command ``fitter`` prints."""

class Material:
    """f_r = kd/pi + ks * specular, per channel."""

    def __init__(self, recipe: Recipe, /) -> None:
        """From an inline recipe, a TOML file, or a file of measured data (MERL, RGL, Cornell, CSV, SGD, ABC).

        Raises:
            BrdfTablesError: the recipe or the data are bad.
            OSError: the file cannot be read.
        """
    @property
    def recipe(self) -> str:
        """The canonical recipe, which gives the same material; of measured data a description."""
    @property
    def model(self) -> str:
        """Name of the model."""
    @property
    def kd(self) -> list[float]:
        """Albedo of the diffuse part, RGB."""
    @property
    def ks(self) -> list[float]:
        """Strength of the specular part, RGB."""
    @property
    def notes(self) -> list[str]:
        """What is to be known of measured data, one line each: how they are kept, and where they gain energy."""
    @property
    def is_isotropic(self) -> bool:
        """Whether turning both directions about the normal changes nothing."""
    def eval(self, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float64]:
        """f_r in 1/sr without the cosine, (..., 3), for directions (..., 3) that broadcast; 0 below the horizon."""
    def __eq__(self, other: object) -> bool: ...

class Table:
    """The mean BRDF of one material. Tables are immutable, and can be used from several threads, compared and pickled."""

    @staticmethod
    def load(path: str | PathLike[str], /) -> Table:
        """Reads a file that ``fitter fit`` or :meth:`save` wrote.

        Raises:
            BrdfTablesError: it is damaged, or no table.
            OSError: it cannot be read.
        """
    @staticmethod
    def from_bytes(data: bytes, /) -> Table:
        """From the bytes of such a file."""
    @staticmethod
    def of_family(material: Recipe, /) -> Table | None:
        """The table of a material from the families within the library, in microseconds: modified Phong, Ward, Beckmann, GGX
        and sheen of any exponent or roughness in their range. ``None`` for another material: :func:`fit` it."""
    def save(self, path: str | PathLike[str], /) -> None:
        """Writes the table, whole or not at all.

        Raises:
            OSError: the place cannot be written.
        """
    def to_bytes(self) -> bytes:
        """The bytes of the file."""
    @property
    def material(self) -> Material:
        """The material that it is of."""
    @property
    def representation(self) -> Literal["diffuse", "zonal", "cubature", "lobes", "paper"]:
        """How the values are kept."""
    def info(self) -> dict[str, Any]:
        """What ``fitter info --json`` says: how the table was made, what it promises, and the errors that were measured
        (fractions)."""
    def specular(self, axis: ArrayLike, solid_angle: ArrayLike, wo: ArrayLike) -> NDArray[np.float32]:
        """The mean over caps of the specular part at unit strength, in 1/sr.

        Args:
            axis: unit vectors (..., 3) along the middles of the caps, z >= 0.
            solid_angle: of the whole caps (...), in (0, 2 pi] sr.
            wo: unit vectors (..., 3) to the eye, z > 0.

        Raises:
            BrdfTablesError: shapes that do not broadcast, or an element outside of the domain; the message has its index.
        """
    def rgb(self, axis: ArrayLike, solid_angle: ArrayLike, wo: ArrayLike) -> NDArray[np.float32]:
        """The whole mean BRDF (..., 3), diffuse part and colours included, in 1/sr; arguments as of :meth:`specular`. The
        colour is taken at the axis of the cap."""
    def __eq__(self, other: object) -> bool: ...

def families() -> list[str]:
    """Names of the families within the library (:meth:`Table.of_family`)."""

def integrate(
    material: Recipe, axis: ArrayLike, solid_angle: ArrayLike, wo: ArrayLike, *, tolerance: float = 1e-6
) -> NDArray[np.float64]:
    """As :meth:`Table.specular`, by deterministic quadrature to a relative tolerance: the truth that tables are measured
    against. Threads are used, and Ctrl-C is heard."""

def monte_carlo(
    material: Recipe,
    axis: ArrayLike,
    solid_angle: ArrayLike,
    wo: ArrayLike,
    *,
    samples: int = 65536,
    seed: int = 1,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """As :meth:`Table.rgb`, by Monte Carlo with the colour of each direction, and its standard error: both (..., 3). The same
    seed gives the same numbers for any number of threads."""

def projected_solid_angle(axis: ArrayLike, solid_angle: ArrayLike) -> NDArray[np.float64]:
    """The integral of the cosine over the part of each cap above the horizon, in sr: times the radiance of a light that fills
    the cap evenly, its irradiance."""

def fit(
    material: Recipe,
    *,
    representation: Literal["auto", "zonal", "cubature", "lobes", "paper"] | None = None,
    solver: Literal["lm", "ga", "ga-lm", "nelder-mead", "bfgs", "gauss-newton"] | None = None,
    lobes: int | None = None,
    tolerance: float = 0.005,
    seed: int = 1,
    threads: int | None = None,
    progress: Callable[[float], object] | None = None,
) -> Table:
    """Fits a table, in seconds, and measures its errors; as ``fitter fit``.

    Args:
        representation: how to keep the mean BRDF; the cheapest that meets the tolerance without it.
        solver: optimiser of the lobes.
        lobes: lobes per cell, 1 to 16; as few as the tolerance needs without it.
        tolerance: on rmse_lobe, a fraction of the peak.
        seed: of every random choice. The same arguments give the same table for any number of threads.
        threads: one per core without it.
        progress: called from the calling thread with the fraction done, some times a second. An exception that it raises
            stops the fit and is passed on, as Ctrl-C is.

    Raises:
        BrdfTablesError: a bad material or option.
    """
