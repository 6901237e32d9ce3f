"""Fitting: from a record to a model whose certificates hold."""

from hysgen.fitting.identify import check_for_fit, fit, fit_path, path_task
from hysgen.fitting.operator import CURVE, PathSize
from hysgen.fitting.path import PathColumns, known_past, path_columns, path_model
from hysgen.fitting.path_regressors import PathTask
from hysgen.fitting.settings import FitSettings, Method

__all__ = [
    "CURVE",
    "FitSettings",
    "Method",
    "PathColumns",
    "PathSize",
    "PathTask",
    "check_for_fit",
    "fit",
    "fit_path",
    "known_past",
    "path_columns",
    "path_model",
    "path_task",
]
