"""The hand-written C of the firmware: in firmware/ of a checkout, inside the package in a wheel."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from hysgen.machine.installed import data_folder

CONTROLLER: Final = "controller"
HOST_BOARD: Final = "board/host"
SIMULATOR_BOARD: Final = "board/simulator"
TARGET_BOARD: Final = "board/c6748"
EMPTY_STORE: Final = ("board", "empty_store.c")
"""Folder and name of the parameter store without memory, of SIMULATOR_BOARD and of boards without flash."""

Sources = list[tuple[str, str]]


def firmware_folder() -> Path:
    """The folder of controller/ and board/. Raises BuildError if the installation lacks them."""
    return data_folder("firmware", holds=CONTROLLER)


def read_sources(folder: str, *patterns: str) -> Sources:
    """(file name, text) of the files in `folder` that match `patterns` (default: the C), sorted by name."""
    paths = [path for pattern in patterns or ("*.[ch]",) for path in (firmware_folder() / folder).glob(pattern)]
    return [(path.name, path.read_text(encoding="utf-8")) for path in sorted(paths)]
