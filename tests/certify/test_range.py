"""A model over a part of its range is the same model there, with certificates of that part."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from fixtures.generated_models import smooth
from fixtures.learner_bench import ANY_CLOCK
from hysgen.certify.certificates import certify
from hysgen.checking.bits import VerifySettings, verify_texts
from hysgen.cli import main
from hysgen.codegen import Options, generate
from hysgen.errors import CertificateError, ModelError
from hysgen.float32.coefficients import coefficients, commit_numbers
from hysgen.float32.reference.accuracy import accuracy
from hysgen.float32.reference.instance import Instance
from hysgen.model.disturbances import Drive
from hysgen.model.file import dump_model, load_model, parse_model, save_model
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model
from hysgen.model.simulate import simulate
from hysgen.model.structs import Status


def singular(rules: int = 6) -> Model:
    """The gain goes through zero at 7.3 um of 0.5 .. 9 um; with 20 rules the C has a window."""
    model = smooth(rules)
    consequents = model.consequents.copy()
    consequents[:, 1] = np.linspace(2e-3, -5e-4, rules)
    return dataclasses.replace(model, consequents=consequents)


@pytest.mark.parametrize("rules", [6, 20])
def test_a_singular_model_is_refused_and_generates_over_the_range_where_it_is_not(rules: int) -> None:
    with pytest.raises(CertificateError, match=r"at y = 9 um.*--displacement-range"):
        generate(singular(rules))
    part = singular(rules).within((1.0, 5.0))
    texts = generate(part)
    report = verify_texts(part, texts, VerifySettings(20_000, 0, compilers=["cc"], levels=["-O2"]))
    assert report.equal, "\n".join(report.lines())
    assert accuracy(part, 20_000).predict_um < 5e-6


@pytest.mark.parametrize("rules", [6, 20])
def test_inside_its_range_the_restricted_model_is_the_same_model(rules: int) -> None:
    whole = smooth(rules)
    part = whole.within((0.8, 4.0), (0.0, 60.0))
    rng = np.random.default_rng(2)
    y, u = rng.uniform(0.8, 4.0, 500).astype(np.float32), rng.uniform(0.0, 60.0, 500).astype(np.float32)
    both = [Instance(model, y, u).predict(y, u) for model in (whole, part)]
    np.testing.assert_array_equal(*both)
    drive = Drive(np.full(2000, 30.0), whole.Ts_s)
    runs = [simulate(model, drive, 3.0).y_um for model in (whole, part)]
    assert 0.8 < runs[0].min() < runs[0].max() < 4.0
    np.testing.assert_array_equal(*runs)


def test_outside_its_range_it_answers_as_at_the_edge_and_says_so() -> None:
    part = smooth(6).within((2.0, 4.0))
    beyond, edge = (Instance(part, np.float32([y]), np.float32([30.0])) for y in (3.0, 3.0))
    u = np.float32([30.0])
    assert beyond.predict(np.float32([5.0]), u) == edge.predict(np.float32([4.0]), u)
    assert beyond.status[0] == Status.Y_CLAMPED
    step = [simulate(part, Drive(np.full(2, 30.0), part.Ts_s), y).y_um[1] for y in (5.0, 4.0)]
    assert step[0] == step[1]


def test_certificates_are_those_of_the_part_and_no_wider_than_those_of_the_whole() -> None:
    whole, part = certify(smooth(6)), certify(smooth(6).within((2.0, 4.0), (0.0, 60.0)))
    assert part.y_range_um == (2.0, 4.0)
    assert whole.gain_lowest.bound <= part.gain_lowest.value < part.gain_highest.value <= whole.gain_highest.bound
    assert part.slope.bound < whole.slope.bound
    y = np.linspace(2.0, 4.0, 4001, dtype=np.float32)
    at_0_V, at_64_V = (Instance(smooth(6), y, y).predict(y, np.full_like(y, u)) for u in (0.0, 64.0))
    gain = (at_64_V.astype(np.float64) - at_0_V) / 64.0
    # Two float32 predictions of up to 5 um, half a last bit each, over 64 V.
    assert part.gain_lowest.bound - 2e-8 < gain.min() < gain.max() < part.gain_highest.bound + 2e-8


@pytest.mark.slow
def test_commit_checks_the_part_only() -> None:
    learner = LearnerSettings()
    with pytest.raises(CertificateError, match="gain"):
        generate(dataclasses.replace(singular(), learner=learner), Options(inverse=False, clock_Hz=ANY_CLOCK.clock_Hz))
    part = dataclasses.replace(singular(), learner=learner).within((1.0, 5.0))
    numbers = commit_numbers(part, coefficients(part), certify(part))
    assert 1.0 < numbers.y_um.min() < numbers.y_um.max() < 5.0
    rows = numbers.table.reshape(numbers.points, 3, -1) * coefficients(part).fold
    np.testing.assert_allclose(rows[:, 0].sum(axis=1), 1.0, atol=1e-6)
    assert "smooth_6_commit" in generate(part, ANY_CLOCK)["smooth_6.h"]


@pytest.mark.parametrize(
    ("displacement", "voltage", "complaint"),
    [
        ((0.4, 3.0), None, "displacement range: 0.4 .. 3 um is no part of the model's 0.5 .. 9 um"),
        ((3.0, 3.0), None, "displacement range: 3 .. 3 um is no part"),
        (None, (-20.0, 121.0), "input range: -20 .. 121 V is no part of the model's -20 .. 120 V"),
    ],
)
def test_a_range_that_is_no_part_is_refused(
    displacement: tuple[float, float] | None, voltage: tuple[float, float] | None, complaint: str
) -> None:
    with pytest.raises(ModelError) as refused:
        smooth(6).within(displacement, voltage)
    assert complaint in str(refused.value)


def test_the_file_keeps_the_range_and_the_rules_and_restricting_twice_is_restricting_once() -> None:
    part = smooth(6).within((1.0, 5.0)).within((2.0, 4.0))
    assert part.grid == smooth(6).grid.within(2.0, 4.0)
    assert parse_model(dump_model(part), "file").grid == part.grid
    assert "spread_um" not in dump_model(smooth(6))
    broken = dump_model(part).replace("[0.5, 9.0]", "[2.5, 9.0]")
    with pytest.raises(ModelError, match="not inside that of the rules"):
        parse_model(broken, "file")


def test_generate_restricts_on_request(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save_model(singular(), tmp_path / "model.json")
    call = ["generate", str(tmp_path / "model.json"), "-o", str(tmp_path / "c")]
    assert main(call) == 2
    assert "--displacement-range" in capsys.readouterr().err
    assert main([*call, "--displacement-range", "1", "5", "--input-range", "0", "100"]) == 0
    written = load_model(tmp_path / "c" / "smooth_6.json")
    assert (written.grid.y_min_um, written.grid.y_max_um, written.u_max_V) == (1.0, 5.0, 100.0)
    manifest = json.loads((tmp_path / "c" / "MANIFEST.json").read_text())
    assert manifest["certificates"]["y_range_um"] == [1.0, 5.0]
