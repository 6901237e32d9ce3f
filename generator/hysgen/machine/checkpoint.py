"""A long computation that goes on where it was interrupted: the result of a step, kept until the whole is done.

The file stands in the cache folder, which holds libraries of this user too. Its name is the digest of the inputs and of
the package's sources, so another record, other settings or other code never find it.
"""

from __future__ import annotations

import contextlib
import pickle
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from hysgen.errors import HysgenError
from hysgen.machine.files import digest, write_whole
from hysgen.machine.native import cache_folder

Result = TypeVar("Result")


def resumed(inputs: Sequence[str], sources: Path, compute: Callable[[], Result]) -> Result:
    """The kept result of `compute` for these inputs, or else compute(), which is then kept.

    sources: folder of the Python files that the result depends on. A result that cannot be kept is returned too.
    """
    path = _path(inputs, sources)
    with contextlib.suppress(OSError, pickle.PickleError, EOFError, AttributeError, ImportError):
        kept: Result = pickle.loads(path.read_bytes())
        return kept
    result = compute()
    with contextlib.suppress(HysgenError, pickle.PickleError, TypeError, AttributeError):
        write_whole(path, pickle.dumps(result))
    return result


def forget(inputs: Sequence[str], sources: Path) -> None:
    """Remove the kept result for these inputs, if there is one."""
    with contextlib.suppress(OSError):
        _path(inputs, sources).unlink()


def _path(inputs: Sequence[str], sources: Path) -> Path:
    code = [digest(path.read_bytes()) for path in sorted(sources.rglob("*.py"))]
    return cache_folder() / f"step-{digest(chr(0).join([*inputs, *code]).encode())[:32]}.pickle"
