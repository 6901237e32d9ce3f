"""Generated C in a folder of its own, for the tools that look at files."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from hysgen.codegen.manifest import c_files


@contextmanager
def folder_of(texts: Mapping[str, str]) -> Iterator[Path]:
    """A folder with the C sources and headers among `texts`, gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="hysgen-") as scratch:
        for file, text in c_files(texts).items():
            Path(scratch, file).write_text(text, encoding="utf-8", newline="\n")
        yield Path(scratch)
