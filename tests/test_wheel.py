"""The wheel is complete: templates, models, compiled kernels and the bundled record are inside."""

import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
CODE = """
import sys, hysgen
print(hysgen.__file__)
from hysgen.cli import main
calls = " ".join(sys.argv[1:]).split(" ; ")
raise SystemExit(max(main(call.split()) for call in calls))
"""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The content of the wheel."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "-w", str(folder)]
    subprocess.run([*build, str(ROOT)], check=True)
    (wheel,) = folder.glob("hysgen-*.whl")
    assert "-py3-none-any" not in wheel.name, "holds compiled kernels"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def run(site: Path, folder: Path, *calls: str, **environment: str) -> str:
    """The output of `hysgen`, called several times in one process, from the wheel, not from the checkout."""
    call = [sys.executable, "-c", CODE, " ; ".join(calls)]
    settings = {**os.environ, "PYTHONPATH": str(site), **environment}
    done = subprocess.run(call, cwd=folder, env=settings, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(site))
    return done.stdout


def test_the_wheel_generates_c_outside_the_checkout(site: Path, tmp_path: Path) -> None:
    assert (site / "hysgen" / "record" / "demo_stage.csv").exists()
    run(site, tmp_path, "generate appendix_a -o out")
    assert (tmp_path / "out" / "appendix_a.c").exists()


def test_the_description_for_an_index_links_to_no_file_of_the_sources(site: Path) -> None:
    (metadata,) = site.glob("hysgen-*.dist-info/METADATA")
    text = metadata.read_text(encoding="utf-8").partition("\n\n")[2]
    assert text.startswith("# hysgen")
    assert "docs/tutorial.md" in text
    assert not re.findall(r"\]\((?!https?:|#)", text)


def test_fit_score_and_describe_need_no_compiler(site: Path, tmp_path: Path) -> None:
    """With the kernels of the wheel; without them the same call asks for a compiler."""
    u = 30.0 + 20.0 * np.sin(0.01 * np.arange(3000.0)) * np.linspace(0.2, 1.0, 3000)
    y = np.convolve(0.06 * u, np.full(8, 0.125))[: u.size]
    rows = np.column_stack([2e-5 * np.arange(u.size), u, y])[20:]
    np.savetxt(tmp_path / "r.csv", rows, "%.9g", ",", header="time_s,voltage_V,displacement_um", comments="")
    nothing = {"PATH": str(tmp_path / "empty"), "CC": "", "HYSGEN_CACHE": str(tmp_path / "cache")}
    calls = ("fit r.csv -o stage.json --method batch", "score stage.json r.csv", "describe stage.json")
    assert "free run" in run(site, tmp_path, *calls, **nothing)
    (library,) = (site / "hysgen" / "machine" / "kernels").glob("kernels-*.so")
    hidden = library.rename(library.with_suffix(".hidden"))
    (tmp_path / "ziglang.py").write_text("")  # takes the place of the package whose compiler this test must not find
    with pytest.raises(AssertionError, match="no C compiler found"):
        run(site, tmp_path, "score stage.json r.csv", **nothing)
    hidden.rename(library)
