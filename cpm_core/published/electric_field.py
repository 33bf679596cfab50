"""The electric field of eq. (8), exact by a convolution or as published by PPPM."""

from __future__ import annotations

from numpy.typing import ArrayLike

from cpm_core.field.convolution import convolved_field
from cpm_core.numerics.real_numbers import check_finite_number, check_image_values
from cpm_core.numerics.types import Array
from cpm_core.parameters.formatting import quote_value
from cpm_core.published.pppm import pppm_field

FIELD_METHODS = ("convolution", "pppm")
"""Methods for the computation of the field."""


def electric_field(
    edge_map: ArrayLike,
    method: str = "convolution",
    exponent: float | None = None,
) -> Array:
    r"""Compute the electric field of the fixed charges, eq. (8).

    Every pixel carries the charge ``-f``; the field on a pixel is the sum over all the others,
    ``E(r) = sum_k -f_k (r - R_k) / |r - R_k|^(exponent + 1)``.

    Parameters
    ----------
    edge_map : array_like, shape (\*shape)
        Edge strength ``f`` of every pixel.
    method : {"convolution", "pppm"}
        How the sum is computed: exactly, as one Fourier convolution, or as published, by direct sums over near charges
        and Poisson's equation on a mesh for far ones (`cpm_core.published.pppm` says how well).
    exponent : float, optional
        Power of the distance with which the force of one charge decays; by default the dimension ``D``. In the plane
        this is the paper's inverse square; in space the inverse square would leave almost no field inside a closed
        surface. The PPPM method has the inverse square only, in space as in the plane.

    Returns
    -------
    ndarray, shape (D, \*shape)
        Field, pointing towards the charges.

    Raises
    ------
    ValueError
        For an unknown method, an exponent that is not positive, or one other than 2 for PPPM.

    Examples
    --------
    >>> strength = cpm.edge_map(cpm.example("disk").values, smoothing=1.0)
    >>> field = cpm.electric_field(strength)
    >>> field.shape, bool(field[1, 32, 48] > 0)  # within the disk, charges are drawn to its right edge
    ((2, 64, 64), True)
    """
    if not isinstance(method, str) or method not in FIELD_METHODS:
        names = " or ".join(f'"{name}"' for name in FIELD_METHODS)
        raise ValueError(f"method is {quote_value(method)} but must be {names}.")
    charges = check_image_values(edge_map)
    if method == "convolution":
        return convolved_field(charges, exponent)
    if exponent is not None:
        wanted = '2 for method "pppm", which solves Poisson\'s equation: use method "convolution"'
        check_finite_number("exponent", exponent, lambda number: number == 2, wanted)
    return pppm_field(charges)
