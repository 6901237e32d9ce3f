"""What certificates and dynamics say: verdicts with their numbers, models over a part of their range."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from fixtures.generated_models import smooth
from fixtures.learner_bench import ANY_CLOCK
from hysgen.certify.certificates import (
    Certificates,
    Dynamics,
    Loop,
    SteadyState,
    certify,
    dynamics,
    loop,
)
from hysgen.certify.enclosure import Extremum
from hysgen.certify.path_inverse import HysteresisSlopes, PathInverse
from hysgen.checking.bits.comparison import VerifySettings, verify_texts
from hysgen.cli import main
from hysgen.codegen import Options, generate
from hysgen.errors import CertificateError, ModelError
from hysgen.float32.coefficients import coefficients, commit_numbers
from hysgen.float32.reference.accuracy import accuracy
from hysgen.float32.reference.instance import Instance
from hysgen.model.disturbances import Drive
from hysgen.model.file import dump_model, load_model, parse_model, save_model
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Grid, Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.simulate import simulate

SLOPES = HysteresisSlopes(least=0.5, largest=1.5, mean_um_per_V=0.08, proved=True)
SOUND = Certificates(
    (0.0, 9.0), (-1.0, 4.0), "um", Extremum(0.2, 0.19, 1.5), Extremum(0.8, 0.81, 2.5), Extremum(0.97, 0.98, 3.5, 0.75),
    (-1.0, 4.0), PathInverse(SLOPES, 0.25, ("modes",)),
)  # fmt: skip


def changed(**parts: object) -> Certificates:
    return dataclasses.replace(SOUND, **parts)  # type: ignore[arg-type]


def test_lines_of_certificates_say_the_verdict_with_its_numbers() -> None:
    gain = "gain 0.2 (y = 1.5 um) .. 0.8 (y = 2.5 um) um/um"
    slope = "slope at most 0.9800 (y = 3.5 um, w = 0.75 um)"
    inverse = (
        "inverse: Eq. (11); slope of the hysteresis 0.5 .. 1.5 of its mean 0.08 um/V (for every past); "
        "zeros of creep and modes within 0.250000; modes left out"
    )
    assert SOUND.lines() == (f"{gain}: holds", f"{slope}: contraction holds, w within -1 .. 4 um", f"{inverse}: holds")
    assert SOUND.summary().title == "certificates: gain holds; contraction holds; inverse holds"
    weak = changed(gain_lowest=Extremum(-0.2, -0.21, 1.5))
    assert weak.lines()[0].endswith(": NOT certified, no inverse can be emitted")
    assert weak.lines()[2] == f"{inverse}: NOT certified, for the gain is not"
    assert weak.summary().title == "certificates: gain NOT certified; contraction holds; inverse NOT certified"
    falling = changed(gain_lowest=Extremum(-0.8, -0.81, 1.5), gain_highest=Extremum(-0.2, -0.19, 2.5), w_unit="V")
    assert "um/V: of one sign, but negative: the model falls as u rises; check" in falling.lines()[0]
    steep = changed(slope=Extremum(1.0, 1.0, 3.5, 0.75))
    assert not steep.contraction_holds
    assert steep.lines()[1].endswith(": contraction certified for -1 .. 4 um only, no free run is to be trusted beyond")
    never = dataclasses.replace(steep, contracting=None)
    assert never.lines()[1].endswith(": contraction NOT certified at any w, the free run is not to be trusted")
    for path, holds in (
        (PathInverse(None, 0.999, ()), True),
        (PathInverse(None, 1.0, ()), False),
        (PathInverse(dataclasses.replace(SLOPES, least=1e-9), 0.0, ()), True),
        (PathInverse(dataclasses.replace(SLOPES, least=0.0, proved=False), 0.0, ()), False),
    ):
        assert (path.holds, changed(path=path).inverse_holds) == (holds, holds)
    assert "(sampled, not proved): NOT certified, a voltage may not exist" in changed(path=path).lines()[2]
    assert changed(path=PathInverse(None, 0.0, ())).lines()[2] == "inverse: Eq. (11): holds"


def test_dynamics_say_their_ranges_and_whether_the_loop_stays_open() -> None:
    states = (
        SteadyState(0.0, 1.0, 0.9, 2e-3, 0.05, True),
        SteadyState(50.0, 5.0, 0.95, 4e-3, 0.08, True),
        SteadyState(100.0, 9.0, 0.0, 9.0, 7.0, False),
    )
    loops = (Loop(1.0, 2.5, 0.0101, 3.0), Loop(10.0, 25.0, 0.2, 3.0))
    found = Dynamics("m", states, loops, 50.0, 45.0)
    assert found.describe().splitlines() == [
        "m: first-order lag, time constant 0.002 .. 0.004 s; DC gain 0.05 .. 0.08 um/V",
        "rest line: 1 um at 0 V .. 9 um at 100 V",
        "loop under 45 V sines about 50 V (part of its box filled, area):",
        "          1 Hz    1.01 %         2.5 um V",
        "         10 Hz   20.00 %          25 um V",
        "the loop stays open as the frequency falls: the model has memory",
    ]
    closed = dataclasses.replace(found, loops=(dataclasses.replace(loops[0], filling=0.0099), loops[1]))
    assert (found.has_memory, closed.has_memory) == (True, False)
    assert closed.describe().splitlines()[-1] == "the loop closes as the frequency falls: a lag, not hysteresis"
    flat = dataclasses.replace(found, loops=(dataclasses.replace(loops[0], filling=0.0),), steady_states=states[2:])
    assert not flat.has_memory
    assert flat.describe().splitlines()[0] == "m: first-order lag, time constant none; DC gain none"
    told = json.loads(json.dumps(found.to_json()))
    assert told == {
        "model": "m", "rests": [vars(state) for state in states], "loops": [vars(loop) for loop in loops],
        "centre_V": 50.0, "amplitude_V": 45.0, "remembers": True,
    }  # fmt: skip


TS_S = 2e-5
A, B, C = 0.98, 0.0016, 0.02
LAG = Model("lag", TS_S, Grid(-5.0, 15.0, 6), np.tile([A, B, C], (6, 1)), 0.0, 100.0)


def test_appendix_a_is_a_lag_of_a_millisecond_whose_loop_closes() -> None:
    found = dynamics(load_model("appendix_a"))
    inner = [state for state in found.steady_states if state.inside and state.tau_s is not None]
    # DESIGN.md, finding 2: time constant of 1 ms, DC gain 0.083 um/V.
    middle = min(inner, key=lambda state: abs(state.u_V - 50.0))
    assert middle.tau_s == pytest.approx(1e-3, rel=0.05)
    assert middle.gain_um_per_V == pytest.approx(0.083, rel=0.05)
    assert not found.has_memory
    lowest, next_one = found.loops[:2]
    # The area of a lag's loop falls with its frequency.
    assert next_one.area_umV / lowest.area_umV == pytest.approx(next_one.f_Hz / lowest.f_Hz, rel=0.02)
    assert "a lag, not hysteresis" in found.describe()


def test_play_operators_keep_the_loop_open_at_any_frequency() -> None:
    # A curve of 0.08 um/V and two plays of 5 and 15 V with 0.01 um/V each, in half ranges of 50 V.
    block = Hysteresis(0.0, 100.0, (5.0, 4.0), (0.1, 0.3), (0.5, 0.5))
    model = dataclasses.replace(LAG, consequents=np.tile([A, 1.0 - A, 0.0], (6, 1)), blocks=(block,))
    found = dynamics(model, f_Hz=[0.2, 2.0, 20.0], amplitude_V=40.0)
    assert found.has_memory
    # In the steady state a play under amplitude A traces a parallelogram: 2 r across, 2 (A - r) high in its own output.
    area = sum(0.01 * 4 * r * (40.0 - r) for r in (5.0, 15.0))
    # The lag of 1 ms adds pi/4 of 2 pi 0.2 Hz 1 ms, 0.1 % of its box, of which the plays fill 3.6 %.
    assert area < found.loops[0].area_umV < 1.04 * area
    assert "has memory" in found.describe()


def test_frequencies_that_cannot_be_simulated_are_refused() -> None:
    with pytest.raises(ModelError, match="3000 Hz is above a 20th of its rate"):
        loop(LAG, 3000.0, 50.0, 10.0)
    with pytest.raises(ModelError, match="choose a higher frequency"):
        loop(LAG, 1e-3, 50.0, 10.0)


def singular(rules: int = 6) -> Model:
    """The gain goes through zero at 7.3 um of 0.5 .. 9 um; with 20 rules the C has a window."""
    model = smooth(rules)
    consequents = model.consequents.copy()
    consequents[:, 1] = np.linspace(2e-3, -5e-4, rules)
    return dataclasses.replace(model, consequents=consequents)


@pytest.mark.parametrize("rules", [6, pytest.param(20, marks=pytest.mark.slow)])
def test_a_singular_model_is_refused_and_generates_over_the_range_where_it_is_not(rules: int) -> None:
    with pytest.raises(CertificateError, match=r"at y = 9 um.*--displacement-range"):
        generate(singular(rules))
    part = singular(rules).within((1.0, 5.0))
    texts = generate(part)
    report = verify_texts(part, texts, VerifySettings(20_000, compilers=["cc"], levels=["-O2"]))
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
