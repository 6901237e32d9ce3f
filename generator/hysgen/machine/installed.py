"""What belongs to the installed package beside its code: its version, templates and the firmware's C sources."""

from __future__ import annotations

from importlib import metadata, resources
from pathlib import Path

from hysgen.errors import BuildError


def version() -> str:
    """The version of the installed distribution."""
    return metadata.version("hysgen")


def data_folder(name: str, holds: str) -> Path:
    """The folder `name` of the distribution that holds the entry `holds`.

    In a wheel it lies inside the package, in a checkout beside `generator/`.
    Raises BuildError if the installation lacks it.
    """
    package = Path(str(resources.files("hysgen")))
    for folder in (package / name, package.parents[1] / name):
        if (folder / holds).exists():
            return folder
    raise BuildError(f"{package}: the folder {name} is missing; install hysgen again")
