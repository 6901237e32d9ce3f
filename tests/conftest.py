"""What every test may lean on: the reference models, the measured records, and how a missing tool is told."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import hysgen  # noqa: F401  before NumPy, whose BLAS reads once how many threads it may have


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-golden", action="store_true", help="write golden files instead of comparing with them")


@pytest.fixture(scope="session")
def measured() -> Path:
    """Folder of the measured records, from the environment variable HYSGEN_DATA."""
    folder = os.environ.get("HYSGEN_DATA")
    if not folder:
        pytest.skip("measured records: set HYSGEN_DATA to their folder to run this test")
    return Path(folder)
