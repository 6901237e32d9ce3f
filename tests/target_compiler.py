"""The C674x compiler for tests that need it. Without it they skip loudly, or fail where HYSGEN_REQUIRE_TOOLS is set."""

from __future__ import annotations

import functools
import os
from pathlib import Path

import pytest

from hysgen import native
from hysgen.errors import BuildError
from hysgen.target import toolchain

SOURCES = Path(__file__).parent / "target"


def need_compiler() -> None:
    """Skip, or fail, the calling test if there is no C674x compiler."""
    try:
        toolchain.folder()
    except BuildError as missing:
        if os.environ.get("HYSGEN_REQUIRE_TOOLS"):
            pytest.fail(str(missing))
        pytest.skip(f"this check did not run: {missing}")


@functools.cache
def firmware(name: str, *flags: str) -> toolchain.Firmware:
    """tests/target/<name>.c for the target."""
    need_compiler()
    return toolchain.compile([(f"{name}.c", (SOURCES / f"{name}.c").read_text(encoding="utf-8"))], flags)


@functools.cache
def host(name: str, declarations: str) -> native.Library:
    """tests/target/<name>.c for this machine."""
    return native.build([(f"{name}.c", (SOURCES / f"{name}.c").read_text(encoding="utf-8"))], declarations, None, ())
