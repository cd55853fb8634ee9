"""Step length from the swing of the acceleration."""

from __future__ import annotations

WEINBERG_K = 0.39
"""Metres per (m/s^2)^(1/4). Measured on the 148 mall walks of folds 1-4: 0.391 pooled, 0.32 to 0.46 for 90 % of walks.
The papers have 0.57 and 0.86, for other people and smoothing. The fusion learns each session's scale on top."""


def weinberg_length_m(swing_mps2: float, k: float = WEINBERG_K) -> float:
    """Length of a step, integrity paper Eq. 16: k (a_max - a_min)^(1/4).

    Differs from the paper: the swing is that of the low-passed norm, not of the vertical component, so that it needs no
    attitude.
    """
    return float(k * max(swing_mps2, 0.0) ** 0.25)


def swing_of_mps2(length_m: float, k: float = WEINBERG_K) -> float:
    """The swing that weinberg_length_m made this length of."""
    return (length_m / k) ** 4


LINEAR_A_M, LINEAR_B_MPS, LINEAR_C_S2 = -0.12, 1.38, 0.0088
"""Regression over the straight legs of the mall walks of folds 1-4: length = A + B period + C swing."""
TRAINED_PERIOD_S = (0.45, 0.65)
"""Where those walks lie; beyond them the line says nothing."""
TRAINED_SWING_MPS2 = 18.0


def linear_length_m(period_s: float, swing_mps2: float) -> float:
    """Length of a step, adaptive filter paper Eq. 6: A + B period + C peak.

    Differs from the paper: the swing from trough to peak takes the place of the peak, and both are kept to the range
    that the regression saw.
    """
    period_s = min(max(period_s, TRAINED_PERIOD_S[0]), TRAINED_PERIOD_S[1])
    return LINEAR_A_M + LINEAR_B_MPS * period_s + LINEAR_C_S2 * min(swing_mps2, TRAINED_SWING_MPS2)
