"""What hysgen says when it cannot go on: one line that names the file, row or field, the fault, and the cure."""

from __future__ import annotations


class HysgenError(Exception):
    """Base of every error meant for the user. The command line prints its text as one line and exits with 2."""


class RecordError(HysgenError):
    """A measured record cannot be used as it is."""


class ModelError(HysgenError):
    """A model, or a model file, is malformed or outside what the project supports."""


class FitError(HysgenError):
    """The record and the chosen structure do not give a trustworthy model."""


class CertificateError(HysgenError):
    """A guarantee that the requested output needs does not hold for this model."""


class BuildError(HysgenError):
    """A compiler is missing, or refuses what it was given."""


class BudgetError(HysgenError):
    """The generated code would not fit the sample period."""


class TargetError(HysgenError):
    """A C674x program does what the processor forbids or what its simulator does not model."""
