"""The version of the installed package and its data folders: templates and the firmware's C sources."""

from __future__ import annotations

from importlib import metadata, resources
from pathlib import Path

from hysgen.errors import BuildError


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
