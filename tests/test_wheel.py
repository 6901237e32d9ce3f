"""The wheel is complete: templates, models, kernels and the bundled record are inside."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.slow
def test_the_wheel_generates_c_outside_the_checkout(tmp_path: Path) -> None:
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "-w", str(tmp_path)]
    subprocess.run([*build, str(ROOT)], check=True)
    (wheel,) = tmp_path.glob("hysgen-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    assert (tmp_path / "site" / "hysgen" / "stage" / "demo_stage.csv").exists()
    # The package must come from the wheel, not from the checkout.
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "site")}
    code = "import hysgen; print(hysgen.__file__); from hysgen.cli import main; raise SystemExit(main())"
    call = [sys.executable, "-c", code, "generate", "appendix_a", "-o", "out"]
    run = subprocess.run(call, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith(str(tmp_path / "site"))
    assert (tmp_path / "out" / "appendix_a.c").exists()
