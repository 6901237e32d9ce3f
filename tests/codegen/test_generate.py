"""Generating: the same bytes always, numbers that read back, refusals with place and value, golden files."""

import dataclasses
import difflib
import getpass
import json
import os
import platform
import re
import struct
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hysgen
from fixtures.generated_models import diagnosed, everything, learning, smooth
from hysgen.api.code import generate_again
from hysgen.cli import main
from hysgen.codegen import Options, generate
from hysgen.codegen.manifest import MANIFEST, read_folder, stale, write
from hysgen.codegen.parameters import literal
from hysgen.errors import BudgetError, CertificateError, HysgenError
from hysgen.export import exports
from hysgen.machine.files import digest
from hysgen.model.file import dump_model, load_model, save_model
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Grid, Model
from hysgen.model.scores import NEXT_TO_NOTHING

GOLDEN = Path(__file__).parents[1] / "golden"


def files_of(folder: Path) -> dict[str, str]:
    """Text of every file below a folder by its path there."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8") for path in files}


@pytest.mark.parametrize(
    "model", [load_model("appendix_a"), everything(), diagnosed(), smooth(50)], ids=lambda model: model.name
)
@pytest.mark.golden
def test_generated_files_are_the_golden_ones(model: Model, request: pytest.FixtureRequest) -> None:
    """Update with `pytest tests/codegen/test_generate.py --update-golden` and look at the diff."""
    folder = GOLDEN / model.name
    texts = {name: text for name, text in generate(model).items() if not name.endswith(".json")}
    if request.config.getoption("--update-golden"):
        write(texts, folder)
    kept = files_of(folder)
    assert sorted(kept) == sorted(texts)
    for name, text in texts.items():
        change = difflib.unified_diff(kept[name].splitlines(), text.splitlines(), "golden", "generated", lineterm="")
        assert kept[name] == text, f"{name}:\n" + "\n".join(list(change)[:60])


@pytest.mark.slow
def test_same_model_gives_the_same_bytes_in_another_process_and_folder(tmp_path: Path) -> None:
    code = (
        "from hysgen.codegen import generate; from hysgen.machine.files import digest;"
        "from hysgen.model.file import load_model;"
        "print(digest(repr(generate(load_model('appendix_b'))).encode()))"
    )
    found = {digest(repr(generate(load_model("appendix_b"))).encode())}
    here = {"PATH": "/usr/bin:/bin", "HOME": str(tmp_path), "PYTHONPATH": os.environ.get("PYTHONPATH", "")}
    for seed in ("1", "2"):
        run = subprocess.run(
            [sys.executable, "-c", code],
            cwd=tmp_path,
            env={**here, "PYTHONHASHSEED": seed, "TZ": "Asia/Tokyo"},
            capture_output=True,
            text=True,
            check=True,
        )
        found.add(run.stdout.strip())
    assert len(found) == 1


def test_nothing_of_machine_or_clock_stands_in_the_files() -> None:
    told = "".join(generate(everything()).values())
    folders = (str(Path.cwd()), str(Path.home()), "/tmp", f"{getpass.getuser()}/")
    for word in (*folders, platform.node(), time.strftime("%Y-")):
        assert word not in told


@pytest.mark.slow
def test_new_numbers_change_parameters_and_nothing_of_the_algorithm() -> None:
    """After re-identification the numbers and the data of the self-test go to the firmware, and model and manifest."""
    for model in (load_model("appendix_a"), everything(), learning()):
        moved = dataclasses.replace(
            model,
            grid=dataclasses.replace(model.grid, y_min_um=model.grid.y_min_um - 0.1, y_max_um=4.0),
            consequents=model.consequents * 0.97,
            weights=model.weights * 1.03,
            u_max_V=110.0,
        )
        before, after = generate(model), generate(moved)
        changed = {name.removeprefix(model.name) for name in before if before[name] != after[name]}
        assert changed == {"_params.h", "_selftest_data.h", ".json", "MANIFEST.json"}


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_literal_reads_back_to_the_same_bits(value: float) -> None:
    text = literal(np.float32(value))
    assert text.endswith("f")
    assert struct.pack("<f", float(np.float32(text[:-1]))) == struct.pack("<f", value)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_literal_refuses_what_is_no_number(value: float) -> None:
    with pytest.raises(HysgenError, match="no float32 literal"):
        literal(np.float32(value))


@pytest.mark.parametrize("model", [load_model("appendix_b"), everything(), learning()], ids=lambda model: model.name)
@pytest.mark.slow
def test_every_constant_reads_back_to_the_bits_beside_it(model: Model) -> None:
    text = generate(model)[f"{model.name}_params.h"]
    pairs = re.findall(r"(-?[\d.]+(?:e[-+]\d+)?)f\s+/\* 0x([0-9a-f]{8}) \*/", text)
    assert len(pairs) > 10
    assert len(pairs) == len(re.findall(r"/\* 0x[0-9a-f]{8} \*/", text)), "bits without a number, or one without bits"
    for number, bits in pairs:
        assert int(np.float32(number).view(np.uint32)) == int(bits, 16)


def test_singular_inverse_is_refused_with_place_and_value() -> None:
    """Gain through zero in the middle of the range; the model itself still generates."""
    model = smooth(6)
    consequents = model.consequents.copy()
    consequents[:, 1] = np.linspace(1e-3, -1e-3, 6)
    singular = dataclasses.replace(model, consequents=consequents)
    with pytest.raises(CertificateError, match=r"smooth_6: the gain df/du is -0\.00\d+ um/V at y = \d") as refused:
        generate(singular)
    assert "\n" not in str(refused.value)
    assert "generate without the inverse" in str(refused.value)
    assert "smooth_6_inverse" not in generate(singular, Options(inverse=False))["smooth_6.h"]


def test_an_inverse_over_a_collapsed_range_or_one_that_noise_moves_is_refused() -> None:
    """One step of the input leaves a range of 0.3 um; of 1 um it does not."""
    collapsed = dataclasses.replace(load_model("appendix_a"), grid=Grid(2.0, 2.3, 6))
    with pytest.raises(CertificateError, match=r"one sample of the input .* off by up to 2\.\d+ of the range"):
        generate(collapsed)
    generate(collapsed, Options(inverse=False))
    generate(dataclasses.replace(collapsed, grid=Grid(2.0, 3.0, 6)))


@pytest.mark.parametrize("stored", [{"noise_floor": {"rms_um": 1.0}}, {"warnings": [f"r.csv: {NEXT_TO_NOTHING}"]}])
def test_a_model_that_does_harm_has_no_c_of_any_kind_without_force(
    stored: dict[str, object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Half the noise moves the inverse by all of its range, or the model explains next to nothing of its record."""
    monkeypatch.chdir(tmp_path)
    harmful = dataclasses.replace(load_model("appendix_a"), scores={"identification": stored})
    save_model(harmful, Path("m.json"))
    calls = [
        "generate m.json -o c",
        "firmware m.json -o f --samples 9",
        *(f"export m.json --to {t} -o e" for t in exports()),
    ]
    if "warnings" in stored:
        calls += ["image m.json -o i --key k", "waveform m.json sine -o u.csv", "loop m.json"]
    for call in calls:
        assert main(call.split()) == 2, call
        assert re.search(r"half the noise|next to nothing", capsys.readouterr().err), call
    assert [path.name for path in tmp_path.iterdir()] == ["m.json"]
    Path("k").write_text(32 * "5")
    code = hysgen.generate(harmful, force=True)
    with pytest.raises(HysgenError, match=r"half the noise|next to nothing"):
        generate_again(harmful, code.write("again"))
    assert generate_again(harmful, "again", force=True).texts == code.texts
    assert main(["image", "m.json", "-o", "i", "--key", "k", "--force"]) == 0


def test_code_over_budget_is_refused_with_the_numbers() -> None:
    fast = dataclasses.replace(load_model("appendix_a"), Ts_s=4e-7)
    with pytest.raises(BudgetError, match=r"about \d+ cycles \(estimate\) \(predict \d+, .*has 150 at 375 MHz"):
        generate(fast)
    measured = Options(cycles={"predict": 100, "simulate": 100, "inverse": 140})
    assert '"budget": 150' in generate(fast, measured)["MANIFEST.json"]


@pytest.mark.slow
def test_more_rules_than_fit_the_sample_period_are_refused_with_the_numbers() -> None:
    """Three parameters per rule, one update per sample: 8 rules fit 7500 cycles, 9 do not."""
    many = dataclasses.replace(smooth(9), learner=LearnerSettings())
    refusal = (
        r"takes about 7\d\d\d cycles .*learn 6\d\d\d, commit \d+\), the period of 20 us has 7500 at 375 MHz; learn"
    )
    with pytest.raises(BudgetError, match=refusal):
        generate(many)
    for fits in (smooth(8), dataclasses.replace(many, learner=LearnerSettings(learned=("gain",)))):
        generate(dataclasses.replace(fits, learner=fits.learner or LearnerSettings()))
    with pytest.raises(HysgenError, match="13 rules; it learns models of up to 12 rules"):
        generate(dataclasses.replace(smooth(13), learner=LearnerSettings()))


def test_measured_cycles_take_the_place_of_estimates() -> None:
    texts = generate(load_model("appendix_a"), Options(cycles={"predict": 160}))
    assert "C674x: 160 cycles. */\nfloat appendix_a_predict" in texts["appendix_a.h"]
    assert "(estimate). */\nfloat appendix_a_simulate" in texts["appendix_a.h"]
    assert json.loads(texts["MANIFEST.json"])["cost"]["cycles"]["predict"] == {"value": 160, "measured": True}


def test_folder_reads_back_as_it_was_written(tmp_path: Path) -> None:
    model = everything()
    texts = generate(model)
    write(texts, tmp_path)
    folder = read_folder(tmp_path)
    assert folder.altered == ()
    assert dump_model(folder.model) == dump_model(model)
    assert dict(folder.texts) == texts
    assert files_of(tmp_path) == texts


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ("not json", "cannot be read"),
        ("[]", "is not a manifest"),
        ('{"schema": "hysgen-manifest", "version": 99}', "is not a manifest of version 1"),
        ('{"schema": "hysgen-manifest", "version": 1, "files": {"../x": ""}, "model_file": "../x"}', "names no files"),
        ('{"schema": "hysgen-manifest", "version": 1, "files": {"x": ""}, "model_file": "x"}', "cannot be read"),
    ],
)
def test_broken_manifest_is_refused_in_one_line(content: str, complaint: str, tmp_path: Path) -> None:
    (tmp_path / "MANIFEST.json").write_text(content)
    with pytest.raises(HysgenError, match=complaint) as refused:
        read_folder(tmp_path)
    assert "\n" not in str(refused.value)
    assert str(tmp_path) in str(refused.value)


def test_the_manifest_is_written_last_and_an_interrupted_write_leaves_none(tmp_path: Path) -> None:
    """A folder with a manifest is whole, whatever its files are called."""
    texts = {MANIFEST: '{"model": "a"}', "A.c": "a", "Z.c": "z", "z/z.c": "z"}
    (tmp_path / "z").write_text("a file where a folder is needed")
    with pytest.raises(HysgenError):
        write(texts, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["A.c", "Z.c", "z"]
    (tmp_path / "z").unlink()
    write(texts, tmp_path)
    assert files_of(tmp_path) == texts


def test_a_file_of_another_digest_is_named_and_it_alone(tmp_path: Path) -> None:
    model = load_model("appendix_a")
    write(generate(model), tmp_path)
    changed = tmp_path / "appendix_a.h"
    changed.write_text(changed.read_text() + " ")
    (message,) = read_folder(tmp_path).altered
    assert message == f"{changed}: is not what was generated (its digest differs from MANIFEST.json)"


LINES = st.lists(st.sampled_from(["", "a", "b"]), max_size=5)


@given(old=LINES, new=LINES)
def test_a_stale_file_is_told_with_its_first_different_line(
    old: list[str], new: list[str], tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("stale")
    (folder / "b.h").write_text("\n".join(old))
    found = stale({"c.c": "", "b.h": "\n".join(new), "a.h": ""}, folder)
    assert [each.name for each in found] == ["a.h", "b.h", "c.c"] if (old or [""]) != (new or [""]) else ["a.h", "c.c"]
    assert {str(each) for each in found} >= {"a.h: missing", "c.c: missing"}
    for each in found[1:-1]:
        line = next(i for i in range(1, 7) if (old or [""])[:i] != (new or [""])[:i])
        assert str(each) == f"b.h: differs from line {line} on"


def test_certificates_numbers_and_errors_are_computed_once_for_a_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[str] = []
    for name in ("certify", "coefficients", "accuracy"):
        original = getattr(hysgen.codegen, name)
        monkeypatch.setattr(
            hysgen.codegen,
            name,
            lambda *given, name=name, call=original, **more: calls.append(name) or call(*given, **more),
        )
    hysgen.generate(learning())
    assert sorted(calls) == ["accuracy", "certify", "coefficients"]
