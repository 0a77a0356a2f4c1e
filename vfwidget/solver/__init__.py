"""Bounded Levenberg–Marquardt for piecewise smooth residuals (Sec. 4), without any font."""

from .least_squares import Result, least_squares

__all__ = ["Result", "least_squares"]
