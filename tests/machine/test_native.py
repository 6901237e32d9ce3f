"""Host builds are cached by source and flags; errors name the place."""

from __future__ import annotations

import subprocess
import sys
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


RUN = """
from hysgen.machine.native import build
library = build([("twice.c", "double twice(double x) { return x + x; }\\n")], "double twice(double);")
print(library.lib.twice(2.5), library.path)
"""


@pytest.mark.slow
def test_a_damaged_library_or_object_is_built_anew(cache: Path) -> None:
    def run() -> list[str]:
        done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, check=False)
        return done.stdout.split() or [f"{done.returncode} {done.stderr}"]

    value, library = run()
    (unit,) = cache.glob("*.o")
    assert value == "5.0"
    other = build([("twice.c", SOURCE.replace("+ x", "- x"))], "double twice(double);")
    whole = Path(library).read_bytes()
    flipped = whole[:5000] + bytes([whole[5000] ^ 255]) + whole[5001:]
    for damaged in (whole[: len(whole) // 2], b"", flipped, other.path.read_bytes()[:-40] + whole[-40:]):
        Path(library).unlink()
        Path(library).write_bytes(damaged)
        unit.write_bytes(damaged)
        assert run() == ["5.0", library]


def test_a_compiler_error_is_one_line_that_names_the_place(cache: Path) -> None:
    with pytest.raises(BuildError, match=r"broken\.c:1:.*error") as fault:
        build([("broken.c", "int f(void) { return missing; }\n")], "int f(void);")
    assert "\n" not in str(fault.value)
    assert list(cache.glob("*.so")) == []


def test_a_missing_compiler_is_named(cache: Path) -> None:
    with pytest.raises(BuildError, match="no-such-cc: no such compiler"):
        build([("twice.c", SOURCE)], "double twice(double);", Toolchain("no-such-cc"))
