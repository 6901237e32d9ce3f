"""A step of a long computation is kept until the whole is done, for the same inputs and the same code only."""

from pathlib import Path

import numpy as np
import pytest

from hysgen.diagnosis import DiagnoseSettings, Diagnosis, procedure
from hysgen.machine.cache import content_digest, forget, resumed, steps
from hysgen.record import Record
from hysgen_lab.stage import Stage, run
from hysgen_lab.stage.signals import nested_amplitudes


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of its own for the steps; compiled libraries stay where they are."""
    folder = tmp_path / "cache"
    folder.mkdir()
    monkeypatch.setattr("hysgen.machine.cache.cache_folder", lambda: folder)
    return folder


@pytest.mark.parametrize("damage", ["cut", "emptied", "flipped", "swapped"])
def test_a_damaged_step_is_computed_anew(damage: str, tmp_path: Path, cache: Path) -> None:
    value = np.arange(1000.0)
    for name in ("x", "y"):
        resumed((name,), tmp_path, lambda: value if name == "x" else -value)  # noqa: B023
    x, y = sorted(cache.glob("step-*"), key=lambda path: path.stat().st_mtime_ns)
    data = x.read_bytes()
    flipped = data[:4000] + bytes([data[4000] ^ 1]) + data[4001:]
    damaged = {"cut": data[:-700], "emptied": b"", "flipped": flipped, "swapped": y.read_bytes()}
    x.write_bytes(damaged[damage])
    np.testing.assert_array_equal(resumed(("x",), tmp_path, lambda: value), value)
    np.testing.assert_array_equal(resumed(("x",), tmp_path, lambda: value[:1]), value, "it is kept again")


def test_a_step_is_computed_once_for_its_inputs_and_code(tmp_path: Path) -> None:
    made: list[int] = []

    def compute() -> int:
        made.append(1)
        return len(made)

    (tmp_path / "code.py").write_text("a = 1")
    assert [resumed(("x",), tmp_path, compute) for _ in range(2)] == [1, 1]
    (tmp_path / "notes.txt").write_text("not code")
    assert [resumed((name,), tmp_path, compute) for name in "xy"] == [1, 2]
    (tmp_path / "code.py").write_text("a = 2")
    assert resumed(("x",), tmp_path, compute) == 3
    forget(("x",), tmp_path)
    assert resumed(("x",), tmp_path, compute) == 4
    assert callable(resumed(("z",), tmp_path, lambda: lambda: 0))  # what cannot be kept is returned all the same


@pytest.mark.slow
def test_an_interrupted_diagnosis_goes_on_with_the_fits_that_it_had(cache: Path) -> None:
    u_V = nested_amplitudes(1e-3, (5.0,), 40.0, 25.0, 3)
    stage = Stage.nominal().with_effects(periodic=(50.3, 0.05, 0.0))
    record = Record.from_arrays(u_V, run(stage, u_V, 1e-3, seed=7).displacement_um, 1e-3)

    def diagnosed(interrupted_at: float = 2.0) -> Diagnosis:
        def progress(fraction: float, line: str) -> None:
            if fraction > interrupted_at:
                raise KeyboardInterrupt

        return procedure.diagnose(record, settings=DiagnoseSettings(resume=True), progress=progress)

    def written() -> dict[str, int]:
        return {str(path): path.stat().st_mtime_ns for path in cache.glob("steps-*/*")}

    with pytest.raises(KeyboardInterrupt):
        diagnosed(0.04)
    first = written()
    assert first
    with pytest.raises(KeyboardInterrupt):
        diagnosed(0.69)
    # The whole search is kept, and no fit was computed again.
    whole = written()
    assert first.items() < whole.items()
    resumed_one = diagnosed()
    assert not list(cache.glob("step*"))
    # The same record gives the same answer, with fits of this process and with those that were kept.
    assert resumed_one.to_json() == procedure.diagnose(record).to_json()


def test_steps_are_kept_by_the_content_of_their_inputs(tmp_path: Path) -> None:
    kept, made = steps(("x",), tmp_path), []

    def compute() -> int:
        made.append(1)
        return len(made)

    a, b = {"a": np.arange(3.0), "b": (1, "x")}, {"b": (1, "x"), "a": np.arange(3.0)}
    assert [kept.get(a, compute), kept.get(b, compute)] == [1, 1]
    assert kept.get({**a, "a": np.arange(3.0) + 1e-15}, compute) == 2
    assert steps(("y",), tmp_path).get(a, compute) == 3
    forget(("x",), tmp_path)
    assert kept.get(a, compute) == 4


def test_values_that_differ_in_anything_have_different_digests() -> None:
    """Type and shape of an array too: its bytes alone may be those of another."""
    zeros = np.zeros(4)
    different = [
        zeros, zeros.reshape(2, 2), zeros.astype(np.int64), zeros.astype(np.float32), zeros[:2], np.full(4, -0.0),
        [0.0] * 4, (0.0,) * 4, [[0.0] * 2, [0.0] * 2], {"a": 0.0}, {"b": 0.0}, {"a": 0}, 0.0, "0.0", None,
        ["a", 0.0], DiagnoseSettings(), DiagnoseSettings(resume=True), [DiagnoseSettings()],
    ]  # fmt: skip
    digests = [content_digest(value) for value in different]
    assert len(set(digests)) == len(different)
    assert {len(digest) for digest in digests} == {32}
    strided = np.arange(8.0)[::2]
    assert content_digest(strided) == content_digest(strided.copy())
