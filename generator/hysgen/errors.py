"""Errors meant for the user; the text is one line that names the file, row or field, the fault, and the cure."""

import difflib
from collections.abc import Iterable


class HysgenError(Exception):
    """Base of all errors of hysgen. The command line prints the text and exits with status 2."""


class RecordError(HysgenError):
    """A measured record cannot be used as it is."""


class RecordWarning(UserWarning):
    """A finding about a record that puts results in doubt; the command line prints it on stderr."""


class ModelError(HysgenError):
    """A model or a model file is malformed or not supported."""


class FitError(HysgenError):
    """No reliable model can be fitted with this record and these settings."""


class CertificateError(HysgenError):
    """A certificate that the requested output requires does not hold for this model."""


class BuildError(HysgenError):
    """A compiler is missing or rejects its input."""


class BudgetError(HysgenError):
    """The generated code takes longer than the sampling period."""


class TargetError(HysgenError):
    """A C674x program violates a rule of the processor, or uses a feature that the simulator does not model."""


def nearest(name: str, known: Iterable[str]) -> str:
    """The text " (did you mean 'x'?)" with the known name of closest spelling, or "" if none is close."""
    by_spelling = {word.lower(): word for word in known}
    close = difflib.get_close_matches(name.lower(), by_spelling, n=1, cutoff=0.6)
    return f" (did you mean '{by_spelling[close[0]]}'?)" if close else ""
