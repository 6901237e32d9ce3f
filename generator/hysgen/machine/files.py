"""Atomic file writes and digests; the version and the data folders of the installed package."""

import contextlib
import hashlib
import os
import sys
import tempfile
from collections.abc import Iterator
from importlib import metadata, resources
from pathlib import Path

from hysgen.errors import BuildError, HysgenError

if sys.platform == "win32":
    import msvcrt

    def _locked(folder: Path) -> int:
        """An open file that stands for the folder: Windows opens no folder, and a lock gives up after ten seconds."""
        stands_for = f"hysgen-{digest(os.fsencode(folder.resolve()))[:32]}.lock"
        place = os.open(Path(tempfile.gettempdir(), stands_for), os.O_RDWR | os.O_CREAT)
        while True:
            with contextlib.suppress(OSError):
                msvcrt.locking(place, msvcrt.LK_LOCK, 1)
                return place
else:
    import fcntl

    def _locked(folder: Path) -> int:
        """The folder, open and locked."""
        place = os.open(folder, os.O_RDONLY)
        fcntl.flock(place, fcntl.LOCK_EX)
        return place


def write_whole(path: Path, content: str | bytes) -> None:
    """Replace `path` by `content` in one step: readers see the old file or the new one, never a part.

    The bytes go to a temporary file in the same folder, are flushed to the disk, and are renamed over `path`; a
    link stays one. A device or a pipe is written to and stays what it is.
    Text is encoded as UTF-8 with '\\n' line ends on every system.
    Raises HysgenError, with the old file untouched, if the folder cannot be written.
    """
    data = content.encode("utf-8") if isinstance(content, str) else content
    scratch: str | None = None
    try:
        if is_special(path):
            path.write_bytes(data)
            return
        path = Path(os.path.realpath(path))
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, scratch = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(scratch, 0o666 & ~_umask())
        os.replace(scratch, path)
        scratch = None
    except OSError as fault:
        raise HysgenError(f"{path}: cannot be written ({fault.strerror}); choose another place") from fault
    finally:
        if scratch is not None:
            with contextlib.suppress(OSError):
                os.unlink(scratch)


@contextlib.contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Make a folder and hold it: another process waits here until it is free. Raises HysgenError if it cannot."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        place = _locked(folder)
    except OSError as fault:
        raise HysgenError(f"{folder}: cannot be written ({fault.strerror}); choose another place") from fault
    try:
        yield
    finally:
        os.close(place)


def is_special(path: Path) -> bool:
    """Whether `path` is a device, a pipe or a socket: it holds nothing to lose, and must not be renamed over."""
    return path.exists() and not path.is_file() and not path.is_dir()


def digest(data: bytes) -> str:
    """SHA-256 of `data` as 64 hexadecimal digits."""
    return hashlib.sha256(data).hexdigest()


SEAL = hashlib.sha256().digest_size
"""Bytes of the digest at the end of a file of the cache; a linker and a loader do not read them."""


def write_sealed(path: Path, data: bytes) -> None:
    """`write_whole`, with the digest of the name and the data behind the data: a damaged file has to be made again."""
    write_whole(path, data + _seal(path, data))


def unsealed(path: Path) -> bytes | None:
    """The data of a file of `write_sealed`; None if it is missing, cut short, altered, or another one of this kind."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    return data[:-SEAL] if data[-SEAL:] == _seal(path, data[:-SEAL]) else None


def _seal(path: Path, data: bytes) -> bytes:
    return hashlib.sha256(path.name.encode() + b"\0" + data).digest()


def _umask() -> int:
    """The process's file mode mask. POSIX has no call that reads it without setting it."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def version() -> str:
    """The version of the installed distribution."""
    return metadata.version("hysgen")


def data_folder(name: str, holds: str) -> Path:
    """The data folder `name` of the distribution, recognised by its entry `holds`.

    In a wheel the folder lies inside the package, in a checkout beside `generator/`.
    Raises BuildError if the folder is missing.
    """
    package = Path(str(resources.files(__package__.partition(".")[0])))
    for folder in (package / name, package.parents[1] / name):
        if (folder / holds).exists():
            return folder
    raise BuildError(f"{package}: the folder {name} is missing; install hysgen again")
