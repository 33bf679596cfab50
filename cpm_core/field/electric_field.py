"""The electric field of eq. (8), by one of two methods."""

from __future__ import annotations

from numpy.typing import ArrayLike

from cpm_core.field.convolution import convolved_field
from cpm_core.field.pppm import pppm_field
from cpm_core.numerics.real_numbers import grid_of_numbers
from cpm_core.numerics.types import Array
from cpm_core.parameters.quotation import shown

METHODS = ("convolution", "pppm")
"""Methods for the computation of the field."""


def electric_field(
    edge_map: ArrayLike,
    method: str = "convolution",
    exponent: float | None = None,
    *,
    cutoff: float = 20.0,
    iterations: int = 50,
) -> Array:
    r"""Electric field of the fixed charges, eq. (8).

    Every pixel carries the charge ``-f``; the field on a pixel is the sum over all the others, ``E(r) = sum_k -f_k (r -
    R_k) / |r - R_k|^(exponent + 1)``.

    Parameters
    ----------
    edge_map : array_like, shape (\*shape)
        Edge strength ``f`` of every pixel.
    method : {"convolution", "pppm"}
        How the sum is computed: exactly, as one Fourier convolution, or as published, by direct sums over near charges
        and Poisson's equation on a mesh for far ones (`cpm_core.field.pppm` compares the two).
    exponent : float, optional
        Power of the distance with which the force of one charge decays; by default the dimension ``D``. In the plane
        this is the paper's inverse square; in space the inverse square would leave almost no field inside a closed
        surface. The PPPM method has the inverse square only.
    cutoff : float
        Reach of the direct sums of the PPPM method [px]; not used by the convolution.
    iterations : int
        Sweeps of over-relaxation of the PPPM method; not used by the convolution.

    Returns
    -------
    ndarray, shape (D, \*shape)
        Field, pointing towards the charges.

    Raises
    ------
    ValueError
        For an unknown method, an exponent that is not positive, and what the PPPM method does not support: volumes,
        other exponents than 2, a cut-off or a number of sweeps out of range.
    """
    if isinstance(method, str) and method == "convolution":
        return convolved_field(grid_of_numbers(edge_map), exponent)
    if not isinstance(method, str) or method != "pppm":
        names = " or ".join(f'"{name}"' for name in METHODS)
        raise ValueError(f"method is {shown(method)} but must be {names}.")
    if exponent not in (None, 2):
        wanted = 'must be 2 for method "pppm", which solves Poisson\'s equation: use method "convolution".'
        raise ValueError(f"exponent is {shown(exponent)} but {wanted}")
    return pppm_field(edge_map, cutoff, iterations)
