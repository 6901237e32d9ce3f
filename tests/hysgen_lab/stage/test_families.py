"""Test stages of five families of hysteresis: each behaves as its physics demands, apart from the analysis."""

import ast
import itertools
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import dblquad

from hysgen_lab.stage import Stage, StageError, run, static_loop, static_path
from hysgen_lab.stage.effects.readings import PeriodicEffect
from hysgen_lab.stage.families import FAMILIES, SCENARIOS, MeshPreisach, Plant, RisingBoucWen, _advanced, plant, records
from hysgen_lab.stage.families.laws import Family, around, draw

Floats = NDArray[np.float64]
WITHOUT_RATE = tuple(name for name in FAMILIES if name != "thermal")


def hysteresis(hidden: Plant) -> Family:
    assert isinstance(hidden.stage.memory, Family)
    return hidden.stage.memory


def bare(family: str, seed: int = 0) -> tuple[Plant, Stage]:
    """A plant, and the stage of its hysteresis alone."""
    hidden = plant(family, "memory", seed)
    return hidden, around(hysteresis(hidden))


def turning(hidden: Plant, turns: int, points: int = 100) -> Floats:
    """A path through random turning points inside the range, `points` samples between two."""
    corners = np.random.default_rng(1).uniform(*hidden.range_V, turns)
    return np.concatenate([np.linspace(a, b, points + 1)[:-1] for a, b in itertools.pairwise(corners)])


def opening(hidden: Plant, stage: Stage, period: int) -> float:
    """Opening of the loop in the middle of the range, share of the stroke, on triangles of `period` samples."""
    low_V, high_V = hidden.range_V
    u_V = low_V + (high_V - low_V) * np.abs((np.arange(2 * period + 1) / period - 1) % 1 * 2 - 1)
    y_um = run(replace(stage, noise=None), u_V, hidden.Ts_s).displacement_um[period + 1 :]  # y(k+1) belongs to u(k)
    return float(y_um[period // 4] - y_um[period // 4 + period // 2]) / hidden.stroke_um


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(3))
def test_stroke_and_opening_are_those_of_a_piezo_stage(family: str, seed: int) -> None:
    hidden, stage = bare(family, seed)
    _, rising, falling = static_loop(stage, *hidden.range_V)
    assert 3 <= hidden.stroke_um <= 50
    assert rising[-1] - rising[0] == pytest.approx(hidden.stroke_um, rel=1e-6)
    assert 0.05 < (falling - rising).max() / hidden.stroke_um < 0.2
    assert 1e-4 <= hidden.noise_um / hidden.stroke_um <= 1 / 3000


@pytest.mark.parametrize("family", WITHOUT_RATE)
@pytest.mark.parametrize("seed", range(8))
def test_the_output_never_moves_against_the_input_after_a_turn(family: str, seed: int) -> None:
    hidden, stage = bare(family, seed)
    u_V = turning(hidden, 60)
    with_input = np.diff(static_path(stage, u_V)) * np.sign(np.diff(u_V))
    assert with_input.min() > 0


def test_every_bouc_wen_hysteresis_that_is_drawn_rises() -> None:
    for seed in range(60):
        drawn = draw(RisingBoucWen, np.random.default_rng(seed), (0.0, 100.0), 1e-3, 10.0)
        # From long strokes to both ends, then back: the steepest part of z comes right after the turn.
        w_um = static_path(around(drawn), np.array([0.0, 100.0, 0.0, 100.0, 99.9, 0.0, 0.1]))
        assert w_um[3] - w_um[4] > 0
        assert w_um[6] - w_um[5] > 0


@pytest.mark.parametrize("family", ["preisach", "relays"])
def test_a_minor_loop_returns_to_where_it_left_and_is_wiped_out(family: str) -> None:
    hidden, stage = bare(family)
    low_V, high_V = hidden.range_V
    at_V = lambda *shares: low_V + (high_V - low_V) * np.array(shares)  # noqa: E731
    w_um = static_path(stage, at_V(0.0, 0.7, 0.3, 0.7, 0.3, 0.5, 0.4, 0.7, 0.8))
    plain = static_path(stage, at_V(0.0, 0.8))
    # Sums of numbers up to the stroke: rounding stays below 1e-11 of it.
    assert w_um[3] == pytest.approx(w_um[1], abs=1e-11 * hidden.stroke_um)
    assert w_um[4] == pytest.approx(w_um[2], abs=1e-11 * hidden.stroke_um)
    assert w_um[7] == pytest.approx(w_um[1], abs=1e-11 * hidden.stroke_um)
    assert w_um[8] == pytest.approx(plain[1], abs=1e-11 * hidden.stroke_um)
    assert w_um[5] > w_um[6]


@pytest.mark.parametrize("family", ["bouc-wen", "jiles-atherton"])
def test_a_differential_hysteresis_is_no_preisach_operator(family: str) -> None:
    hidden, stage = bare(family)
    low_V, high_V = hidden.range_V
    w_um = static_path(stage, low_V + (high_V - low_V) * np.array([0.0, 0.7, 0.4, 0.7]))
    # The minor loop does not close: far above what the integration leaves, 1e-6 of the stroke.
    assert abs(w_um[3] - w_um[1]) > 1e-4 * hidden.stroke_um


@pytest.mark.parametrize("family", ["bouc-wen", "jiles-atherton"])
def test_the_integration_does_not_depend_on_the_samples(family: str) -> None:
    hidden, stage = bare(family)
    fine_V = turning(hidden, 60, points=400)
    coarse = static_path(stage, fine_V[::400])
    # A tenth of the noise at least; measured: 7e-7 of the stroke.
    np.testing.assert_allclose(static_path(stage, fine_V)[::400], coarse, atol=1e-5 * hidden.stroke_um)


@pytest.mark.parametrize(("low", "high", "within"), [(0.2, 0.7, 1e-5), (0.5, 0.506, 2e-3)])
def test_the_mesh_integrates_its_density(low: float, high: float, within: float) -> None:
    hidden, stage = bare("preisach")
    memory = hysteresis(hidden)
    assert isinstance(memory, MeshPreisach)
    low_V, high_V = hidden.range_V
    at_V = low_V + (high_V - low_V) * np.array([low, high])
    w_um = static_path(stage, np.array([low_V, at_V[1], at_V[0]]))
    relays_um, _ = dblquad(lambda b, a: float(memory.density(np.array(a), np.array(b))), *at_V, at_V[0], lambda a: a)
    reversible_um = memory.slope_um_per_V * (at_V[1] - at_V[0])
    # The density is constant in cells of 1/400 of the range: measured 2e-6 and 3e-4.
    assert w_um[1] - w_um[2] - reversible_um == pytest.approx(memory.height_um * relays_um, rel=within)


def test_relays_are_finer_than_the_noise() -> None:
    for seed in range(3):
        hidden, _ = bare("relays", seed)
        weights_um = hysteresis(hidden).equation()[1]["weight_um"]
        assert weights_um.max() < 0.5 * hidden.noise_um
        assert weights_um.max() > 3 * weights_um.min()


def test_thermal_hysterons_depend_on_the_rate_and_creep() -> None:
    hidden, no_lag = bare("thermal")
    assert opening(hidden, no_lag, 500) - opening(hidden, no_lag, 8000) > 1e-3
    low_V, high_V = hidden.range_V
    middle_V = 0.5 * (low_V + high_V)
    held_V = np.concatenate([np.linspace(low_V, middle_V, 200), np.full(10_000, middle_V)])
    y_um = run(replace(hidden.stage, noise=None), held_V, hidden.Ts_s).displacement_um
    # No lag is left after 400 samples, and the stage has no other creep.
    assert y_um[-1] - y_um[600] > 5 * hidden.noise_um


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.slow
def test_the_same_seed_gives_the_same_records_and_another_seed_does_not(family: str) -> None:
    first, again = (records(plant(family, "delay", 3), (900, 600)) for _ in range(2))
    other = records(plant(family, "delay", 4), (900, 600))
    for one, two, three in zip(first, again, other, strict=True):
        assert all(a.tobytes() == b.tobytes() for a, b in zip(one, two, strict=True))
        assert one[1].tobytes() != three[1].tobytes()


def test_both_records_cover_the_range_early_after_an_unknown_past() -> None:
    hidden = plant("preisach", "memory", 0)
    low_V, high_V = hidden.range_V
    for u_V, y_um in records(hidden, (4000, 4000)):
        early = u_V[: len(u_V) // 10]
        assert early.min() == pytest.approx(low_V)
        assert early.max() == pytest.approx(high_V)
        from_rest = run(hidden.stage, u_V, hidden.Ts_s).displacement_um
        # The past is worth many times the noise at first, and is forgotten where the range is covered.
        assert abs(y_um[0] - from_rest[0]) > 20 * hidden.noise_um
        assert np.abs(y_um - from_rest)[1500:].max() < 12 * hidden.noise_um


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_a_plant_has_the_effects_of_its_scenario(scenario: str) -> None:
    hidden = plant("bouc-wen", scenario, 0)
    assert set(hidden.effects) == {"memory", *SCENARIOS[scenario]}
    assert hidden.stage.lag_s >= 2 * hidden.Ts_s


def test_a_disturbance_has_the_same_phase_at_the_first_row_of_both_records() -> None:
    line = PeriodicEffect(47.3, 0.01, 1.1)
    later = _advanced(line, 3.7)
    assert np.sin(2 * np.pi * 47.3 * 3.7 + later.phase_rad) == pytest.approx(np.sin(1.1), abs=1e-9)


def test_the_families_import_the_virtual_stage_alone() -> None:
    found = set()
    for source in resources.files("hysgen_lab.stage.families").iterdir():
        if source.name.endswith(".py"):
            for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
                names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                found |= {*names, *([node.module or "."] if isinstance(node, ast.ImportFrom) else [])}
    inside = {name for name in found if name.startswith((".", "hysgen"))}
    assert inside
    assert all(name.startswith("hysgen_lab.stage.") for name in inside)


def test_an_unknown_family_or_scenario_is_refused() -> None:
    with pytest.raises(StageError, match="family: plays"):
        plant("plays", "memory", 0)
    with pytest.raises(StageError, match="scenario: fire"):
        plant("preisach", "fire", 0)
