"""The bundled record: the laboratory's stage at 50 kHz, under a command that excites memory, lag, creep and modes."""

from __future__ import annotations

import tempfile
from importlib import resources
from pathlib import Path
from typing import Final

from hysgen.record.data import Record
from hysgen.record.read import load_record

NAME: Final = "demo_stage.csv"

IDENTIFICATION_ROWS: Final = 46_003
"""Rows for identification; validation begins at this row, counted from 0."""


def bundled_csv() -> str:
    """The record as it is shipped with the package."""
    return resources.files(__package__).joinpath(NAME).read_text(encoding="utf-8")


def demo_record() -> Record:
    """The bundled record, read as any other; its first IDENTIFICATION_ROWS are for identification."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "demo.csv"
        path.write_text(bundled_csv(), encoding="utf-8")
        return load_record(path)
