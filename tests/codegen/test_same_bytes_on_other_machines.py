"""The same bytes on every processor: generation under other BLAS kernels, C libraries and thread counts."""

import json
import math
import os
import subprocess
import sys
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hysgen.codegen import generate
from hysgen.machine.files import digest
from hysgen.machine.reproducible import (
    exponential,
    rounded_down,
    rounded_up,
    spectral_radius,
)
from hysgen_lab.firmware.reference_models import firmware_models

GENERATE = (
    "import json; from hysgen.codegen import generate; from hysgen.machine.files import digest;"
    "from hysgen_lab.firmware.reference_models import firmware_models;"
    "print(json.dumps([{n: digest(t.encode()) for n, t in generate(m).items()} for m in firmware_models()]))"
)

SIMD = np.show_config(mode="dicts")["SIMD Extensions"]

# Old kernels of OpenBLAS, which newer processors run too; NumPy without its vector code; glibc without its own for FMA.
# What a machine does not know of it, it leaves out. AVX-512 kernels end older processors, so they are not tried.
MACHINES = {
    "Prescott": {
        "OPENBLAS_CORETYPE": "Prescott",
        "OPENBLAS_NUM_THREADS": "1",
        "NPY_DISABLE_CPU_FEATURES": " ".join([*SIMD.get("found", []), *SIMD.get("not found", [])]),
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX2_Usable,-FMA_Usable",
    },
    "Nehalem with 2 threads": {"OPENBLAS_CORETYPE": "Nehalem", "OPENBLAS_NUM_THREADS": "2"},
}


@pytest.fixture(scope="module")
def here() -> list[dict[str, str]]:
    return [{name: digest(text.encode()) for name, text in generate(model).items()} for model in firmware_models()]


@pytest.mark.parametrize(
    "machine",
    [
        pytest.param(MACHINES["Prescott"], marks=pytest.mark.proof, id="Prescott"),
        pytest.param(MACHINES["Nehalem with 2 threads"], id="Nehalem with 2 threads"),
    ],
)
@pytest.mark.slow
def test_the_firmwares_models_generate_to_the_same_bytes_on_other_machines(
    machine: dict[str, str], here: list[dict[str, str]]
) -> None:
    run = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", GENERATE],
        env=os.environ | machine,
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(run.stdout) == here


@given(st.floats(-745.0, 700.0))
def test_exponential_is_within_a_unit_of_the_last_place(x: float) -> None:
    exact = Decimal(x).exp()
    found = float(exponential(np.array([x]))[0])
    assert abs(Decimal(found) - exact) <= Decimal(math.ulp(found))


@given(st.floats(allow_nan=False), st.integers(1, 14))
def test_rounding_outward_keeps_a_bound(x: float, digits: int) -> None:
    low, high = rounded_down(x, digits), rounded_up(x, digits)
    assert low <= x <= high
    if math.isfinite(high) and abs(x) > 1e-300:
        assert high - low <= 1.01 * abs(x) * 10.0 ** (1 - digits)
        assert float(f"{high:.{digits - 1}e}") == high


@given(
    st.lists(st.floats(0.05, 0.97), min_size=1, max_size=3),
    st.floats(0.1, 3.0),
    st.floats(0.1, 0.98),
    st.integers(0, 9),
)
def test_the_spectral_radius_is_the_largest_modulus_of_the_eigenvalues_put_in(
    real: list[float], angle: float, modulus: float, seed: int
) -> None:
    """Real eigenvalues and a complex pair, behind a change of basis that keeps them to 1e-12."""
    n = len(real) + 2
    blocks = np.diag([0.0, 0.0, *real])
    blocks[:2, :2] = modulus * np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    basis = np.eye(n) + 0.1 * np.random.default_rng(seed).standard_normal((n, n))
    found = spectral_radius(basis @ blocks @ np.linalg.inv(basis))
    apart = np.abs(np.subtract.outer(real, real))[np.triu_indices(len(real), 1)]
    if apart.size == 0 or apart.min() > 1e-3:
        assert 1.0 - 1e-11 < found / max(modulus, *real) < 1.0 + 1.2e-8, "above, by at most a unit of the ninth digit"
