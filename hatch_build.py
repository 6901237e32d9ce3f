"""Hooks of the build: compiled kernels in the wheel where a C compiler is at hand; a description without dead links."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

PICTURE = re.compile(r"^!\[[^\]]*\]\((?!https?:)[^)]*\)\n+", re.MULTILINE)
LINK = re.compile(r"\[([^\]]*)\]\((?!https?:|#)[^)]*\)")


class KernelsHook(BuildHookInterface):  # type: ignore[type-arg]
    """Compile the kernels and tag the wheel with this platform; the library needs no Python ABI."""

    _scratch: tempfile.TemporaryDirectory[str] | None = None

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        machine = Path(self.root) / "generator" / "hysgen" / "machine"
        recipe = importlib.util.spec_from_file_location("kernel_build", machine / "kernel_build.py")
        if recipe is None or recipe.loader is None:
            raise FileNotFoundError(machine / "kernel_build.py")
        module = importlib.util.module_from_spec(recipe)
        recipe.loader.exec_module(module)
        compiler = module.find_compiler()
        if compiler is None:
            self.app.display_warning("no C compiler: the wheel holds no kernels and compiles them at the first use")
            return
        self._scratch = tempfile.TemporaryDirectory()
        try:
            library = module.build_kernels(machine / "kernels", compiler, Path(self._scratch.name))
        except subprocess.CalledProcessError as fault:
            self.app.display_warning(f"{compiler} cannot build the kernels, so the wheel holds none: {fault.stderr}")
            return
        build_data["force_include"][str(library)] = f"hysgen/machine/kernels/{library.name}"
        build_data["pure_python"] = False
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"py3-none-{platform}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        if self._scratch is not None:
            self._scratch.cleanup()


class DescriptionHook(MetadataHookInterface):
    """The README as description of the package: beside an index, files of the sources are named and not linked."""

    def update(self, metadata: dict[str, Any]) -> None:
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        text = LINK.sub(r"\1", PICTURE.sub("", text))
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
