"""Diagnosis: what a simulation gets wrong, which cause it has, what extending the model gains."""

from hysgen.diagnosis.answer import Diagnosis, NamedCause, Price, Refused
from hysgen.diagnosis.procedure import DiagnoseSettings, diagnose

__all__ = ["DiagnoseSettings", "Diagnosis", "NamedCause", "Price", "Refused", "diagnose"]
