"""Fixtures of the exports: the C of a model is generated once per process, the folders are shared by all tests."""

from __future__ import annotations

import functools
from pathlib import Path

import pytest

from hysgen import export as exporting
from hysgen.codegen import Options, generate
from hysgen.model.file import dump_model
from hysgen.model.model import Model


@pytest.fixture(autouse=True)
def _generated_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Generate the C of a model once per process: most of the time of an export."""
    monkeypatch.setattr(exporting, "generate", lambda model, options=None: dict(_generated(_Key(model, options))))


class _Key:
    """A model and options as the key of a cache: their text."""

    def __init__(self, model: Model, options: Options | None) -> None:
        self.model, self.options = model, options or Options()
        self.text = dump_model(model) + repr(self.options)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)


@functools.cache
def _generated(key: _Key) -> dict[str, str]:
    return generate(key.model, key.options)


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("export")
