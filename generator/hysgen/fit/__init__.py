"""Fitting: from a record to a model whose certificates hold."""

from hysgen.fit.identify import fit
from hysgen.fit.settings import FitSettings, Method

__all__ = ["FitSettings", "Method", "fit"]
