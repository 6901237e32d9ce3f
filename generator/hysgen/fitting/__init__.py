"""Fitting: from a record to a model whose certificates hold."""

from hysgen.fitting.identify import fit
from hysgen.fitting.initial_state import estimate_starts
from hysgen.fitting.settings import FitSettings, Method
from hysgen.fitting.shape import ShapeFit, fit_shape

__all__ = ["FitSettings", "Method", "ShapeFit", "estimate_starts", "fit", "fit_shape"]
