"""Fitting: from a record to a model whose certificates hold."""

from hysgen.fit.identify import fit
from hysgen.fit.settings import FitSettings, Method
from hysgen.fit.shape import ShapeFit, fit_shape
from hysgen.fit.start import estimate_starts

__all__ = ["FitSettings", "Method", "ShapeFit", "estimate_starts", "fit", "fit_shape"]
