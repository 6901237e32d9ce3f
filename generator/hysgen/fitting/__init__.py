"""Fitting: from a record to a model whose certificates hold."""

from hysgen.fitting.identify import fit, fit_path, partition
from hysgen.fitting.initial_state import estimate_starts
from hysgen.fitting.path import CURVE, PathColumns, PathSize, PathTask, path_columns, path_model
from hysgen.fitting.settings import FitSettings, Method
from hysgen.fitting.shape import ShapeFit, fit_shape

__all__ = [
    "CURVE",
    "FitSettings",
    "Method",
    "PathColumns",
    "PathSize",
    "PathTask",
    "ShapeFit",
    "estimate_starts",
    "fit",
    "fit_path",
    "fit_shape",
    "partition",
    "path_columns",
    "path_model",
]
