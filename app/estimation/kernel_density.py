"""Bandwidth of a Gaussian kernel density estimate."""

from __future__ import annotations

from app.errors import InvalidInput


def silverman_bandwidth(spread: float, dimensions: int, count: int) -> float:
    """Silverman's rule, spread * (4 / ((d + 2) N))^(1 / (d + 4)), unconstrained-smartphones paper.

    Parameters
    ----------
    spread : standard deviation of the data in one dimension.  dimensions : d >= 1.  count : N >= 1 points.

    Raises
    ------
    InvalidInput : no dimension, no point or a negative spread.

    Notes
    -----
    Differs from the paper: it writes the variance where the rule needs a standard deviation.
    """
    if dimensions < 1 or count < 1 or not spread >= 0.0:
        raise InvalidInput(f"no bandwidth for {count} points in {dimensions} dimensions with spread {spread}")
    return float(spread * (4.0 / ((dimensions + 2.0) * count)) ** (1.0 / (dimensions + 4.0)))
