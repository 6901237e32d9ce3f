"""The compiler that pip brings: same bits as the reference, and generated C for systems that are not this one."""

import subprocess
from pathlib import Path

import pytest

from fixtures.proof_models import SHIPPED, shipped
from fixtures.tools import library
from hysgen.checking.bits.comparison import VerifySettings, verify_texts
from hysgen.codegen.manifest import write
from hysgen.machine import kernel_build, native

pytestmark = pytest.mark.slow

SYSTEMS = {
    "Windows": ("-target", "x86_64-windows-gnu"),
    "macOS": ("-target", "aarch64-macos"),
    "Cortex-M4": ("-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m4"),
    "Cortex-M7": ("-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m7"),
}


@pytest.fixture
def alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Words that run pip's compiler, where the system has none and nothing is compiled yet."""
    library("ziglang")
    monkeypatch.setattr(kernel_build, "SYSTEM", ())
    monkeypatch.setenv("CC", "")
    monkeypatch.setenv("HYSGEN_CACHE", str(tmp_path / "cache"))
    native.compiler_version.cache_clear()
    return kernel_build.compiler_call("cc")


def test_a_machine_without_a_compiler_verifies_with_that_of_pip(alone: list[str]) -> None:
    folder = shipped("appendix_a")
    report = verify_texts(folder.model, folder.texts, VerifySettings(9000, compilers=["cc"]))
    assert report.equal
    assert report.builds[0].startswith("clang ")
    native.compiler_version.cache_clear()


@pytest.mark.parametrize("system", SYSTEMS)
def test_generated_c_compiles_for_other_systems(alone: list[str], system: str, tmp_path: Path) -> None:
    for name in SHIPPED:
        folder = tmp_path / name
        write(shipped(name).texts, folder)
        flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2", *SYSTEMS[system]]
        for unit in sorted(path.name for path in folder.glob("*.c")):
            call = [*alone[:2], *flags, "-c", "-o", f"{unit}.o", unit]
            done = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
            assert (done.returncode, done.stderr) == (0, "")
