"""A long computation that goes on where it was interrupted: results of its steps, kept until the whole is done.

The files stand in the cache folder, which holds libraries of this user too. Their names are digests of the inputs and
of the package's sources, so another record, other settings or other code never find them.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import pickle
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from hysgen.errors import HysgenError
from hysgen.machine.files import digest, write_whole
from hysgen.machine.native import cache_folder

Result = TypeVar("Result")


def resumed(inputs: Sequence[str], sources: Path, compute: Callable[[], Result]) -> Result:
    """The kept result of `compute` for these inputs, or else compute(), which is then kept.

    sources: folder of the Python files that the result depends on. A result that cannot be kept is returned too.
    """
    return _kept(_path("step", inputs, sources).with_suffix(".pickle"), compute)


@dataclass(frozen=True)
class Steps:
    """Results of many steps of one computation, each in its own file of `folder` under the digest of its inputs."""

    folder: Path

    def get(self, inputs: Any, compute: Callable[[], Result]) -> Result:
        """The kept result of `compute` for these inputs, or else compute(), which is then kept."""
        return _kept(self.folder / f"{content_digest(inputs)}.pickle", compute)


def steps(inputs: Sequence[str], sources: Path) -> Steps:
    """The kept steps of a computation with these inputs; arguments as of `resumed`."""
    return Steps(_path("steps", inputs, sources))


def content_digest(value: Any) -> str:
    """Digest of a value from arrays, mappings, sequences, dataclasses (their fields with a repr) and plain values."""
    hasher = hashlib.sha256()

    def add(part: Any) -> None:
        hasher.update(f"{type(part).__name__}(".encode())
        if isinstance(part, np.ndarray):
            hasher.update(f"{part.dtype}{part.shape}".encode() + np.ascontiguousarray(part).tobytes())
        elif isinstance(part, Mapping):
            add([item for key in sorted(part) for item in (key, part[key])])
        elif isinstance(part, list | tuple):
            for item in part:
                add(item)
        elif dataclasses.is_dataclass(part):
            add([getattr(part, item.name) for item in dataclasses.fields(part) if item.repr])
        else:
            hasher.update(repr(part).encode())
        hasher.update(b")")

    add(value)
    return hasher.hexdigest()[:32]


def _kept(path: Path, compute: Callable[[], Result]) -> Result:
    with contextlib.suppress(OSError, pickle.PickleError, EOFError, AttributeError, ImportError):
        result: Result = pickle.loads(path.read_bytes())
        return result
    result = compute()
    with contextlib.suppress(HysgenError, pickle.PickleError, TypeError, AttributeError):
        write_whole(path, pickle.dumps(result))
    return result


def forget(inputs: Sequence[str], sources: Path) -> None:
    """Remove the kept result and the kept steps for these inputs, if there are any."""
    with contextlib.suppress(OSError):
        _path("step", inputs, sources).with_suffix(".pickle").unlink()
    shutil.rmtree(_path("steps", inputs, sources), ignore_errors=True)


def _path(kind: str, inputs: Sequence[str], sources: Path) -> Path:
    code = [digest(path.read_bytes()) for path in sorted(sources.rglob("*")) if path.suffix in (".py", ".c", ".h")]
    return cache_folder() / f"{kind}-{digest(chr(0).join([*inputs, *code]).encode())[:32]}"
