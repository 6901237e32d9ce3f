"""Host builds are cached by source and flags; errors name the place."""

from __future__ import annotations

from pathlib import Path

import pytest

from hysgen.errors import BuildError
from hysgen.machine.native import Toolchain, build

SOURCE = "double twice(double x) { return x + x; }\n"


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("HYSGEN_CACHE", str(tmp_path))
    return tmp_path


def test_a_library_is_compiled_once_per_source_and_flags(cache: Path) -> None:
    first = build([("twice.c", SOURCE)], "double twice(double);")
    stamp = first.path.stat().st_mtime_ns
    again = build([("twice.c", SOURCE)], "double twice(double);")
    other = build([("twice.c", SOURCE)], "double twice(double);", Toolchain(flags=("-O0",)))
    assert again.path == first.path
    assert again.path.stat().st_mtime_ns == stamp
    assert other.path != first.path
    assert first.lib.twice(2.5) == other.lib.twice(2.5) == 5.0


def test_a_compiler_error_is_one_line_that_names_the_place(cache: Path) -> None:
    with pytest.raises(BuildError, match=r"broken\.c:1:.*error") as fault:
        build([("broken.c", "int f(void) { return missing; }\n")], "int f(void);")
    assert "\n" not in str(fault.value)
    assert list(cache.glob("*.so")) == []


def test_a_missing_compiler_is_named(cache: Path) -> None:
    with pytest.raises(BuildError, match="no-such-cc: no such compiler"):
        build([("twice.c", SOURCE)], "double twice(double);", Toolchain("no-such-cc"))
