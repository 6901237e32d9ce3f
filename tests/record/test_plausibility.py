"""Valid records are never refused; saturated sensors and exchanged columns are found.

The records come from the virtual stage, with hysteresis, modes and noise that the checks do not model.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from hysgen.errors import RecordError
from hysgen.record import Record
from hysgen.record.checks import at_end, swapped
from hysgen.record.segment import Segment
from hysgen_lab.stage import (
    BoucWen,
    DelayEffect,
    PeriodicEffect,
    ResonanceEffect,
    SaturationEffect,
    Stage,
    StickSlipEffect,
    run,
)
from hysgen_lab.stage.signals import fig5, fig8, fig11_non_harmonic, plateaus

TS_S = 20e-6
LAB = Stage.laboratory()
STAGES = {
    "laboratory": LAB,
    "no noise": LAB.quiet(),
    "Bouc-Wen": replace(LAB, memory=BoucWen()),
    "amplifier clips": LAB.with_effects(saturation=SaturationEffect(5.0, 45.0)),
    "amplifier clips, no noise": LAB.with_effects(saturation=SaturationEffect(5.0, 45.0)).quiet(),
    "amplifier clips, no noise, no modes": Stage().with_effects(saturation=SaturationEffect(5.0, 45.0)).quiet(),
    "amplifier clips, sensor in steps": replace(
        Stage().with_effects(saturation=SaturationEffect(5.0, 45.0)), noise=None
    ),
    "slew": LAB.with_effects(slew=2000.0),
    "soft mode": LAB.with_effects(resonance=(ResonanceEffect(150.0, 0.02),)),
    "late": LAB.with_effects(delay=DelayEffect(samples=7.0)),
    "sticks": LAB.with_effects(stick_slip=StickSlipEffect(0.05)),
    "outliers": LAB.with_effects(outliers=(0.002, 1.0)),
    "drifts": LAB.with_effects(drift=(1.0, 0.5)),
    "hum": LAB.with_effects(periodic=(PeriodicEffect(50.0, 0.3),)),
    "proportional": replace(Stage(), memory=None).quiet(),
}
DRIVES = {
    "fig5": fig5(TS_S, "identification"),
    "fig8": fig8(TS_S, "identification"),
    "non-harmonic": fig11_non_harmonic(TS_S),
    "plateaus": plateaus(TS_S, [30.0, 52.0, 14.0, 41.0, 30.0], 0.030, 0.004),
}


@cache
def measured(stage: str, drive: str) -> tuple[np.ndarray, np.ndarray]:
    measurement = run(STAGES[stage], DRIVES[drive], TS_S, seed=3)
    return measurement.voltage_V, measurement.displacement_um


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("stage", STAGES)
def test_sound_record_is_never_refused_nor_called_exchanged(stage: str, drive: str) -> None:
    u_V, y_um = measured(stage, drive)
    nanometres = 1e3 * y_um - 200.0
    too_far = ("more than a piezo stage moves",) if np.ptp(nanometres) > 1e3 else ()
    for sensor, said in ((y_um, ()), (-y_um, ("falls as",)), (nanometres, too_far)):
        record = Record.from_arrays(u_V, sensor, TS_S)
        assert not [line for line in record.warnings if "exchanged" in line]
        # Where nothing moves the sensor at an amplifier's limit, or the stage sticks there, a warning is in place.
        if not stage.startswith("amplifier clips, ") and stage != "sticks":
            assert len(record.warnings) == len(said), record.warnings
            assert all(phrase in line for phrase, line in zip(said, record.warnings, strict=True))


@pytest.mark.parametrize("drive", ["fig5", "fig8", "non-harmonic"])
@pytest.mark.parametrize("stage", ["laboratory", "Bouc-Wen", "late", "sticks", "drifts", "slew"])
@pytest.mark.parametrize("end", ["highest", "lowest"])
def test_sensor_at_its_end_is_refused_wherever_it_clips(stage: str, drive: str, end: str) -> None:
    u_V, y_um = measured(stage, drive)
    low, high = y_um.min() + 0.1 * np.ptp(y_um), y_um.max() - 0.1 * np.ptp(y_um)
    clipped = np.minimum(y_um, high) if end == "highest" else np.maximum(y_um, low)
    with pytest.raises(
        RecordError, match=f"displacement_um stays at its {end} value .* samples: the sensor is at its end"
    ):
        Record.from_arrays(u_V, clipped, TS_S)
    accepted = Record.from_arrays(u_V, clipped, TS_S, accept=["saturation"])
    assert [line for line in accepted.warnings if "the sensor is at its end" in line]
    runs = [Segment("0", u_V[:stop], clipped[:stop], {}) for stop in (clipped.size, 9)]
    assert np.array_equal(at_end(runs)[0], clipped == (high if end == "highest" else low))
    with pytest.raises(RecordError, match="the sensor is at its end"):
        Record.from_arrays(u_V, -clipped, TS_S)


@pytest.mark.parametrize("drive", ["fig5", "fig8"])
@pytest.mark.parametrize("stage", ["laboratory", "Bouc-Wen", "late", "sticks", "outliers"])
def test_exchanged_columns_are_refused_where_the_voltage_is_noisy_and_the_displacement_is_not(
    stage: str, drive: str
) -> None:
    u_V, y_um = measured(stage, drive)
    with pytest.raises(RecordError, match=r"displacement_um runs ahead of voltage_V in \d+ cycles; the two col"):
        Record.from_arrays(y_um, u_V, TS_S, accept=["saturation"])


def test_voltage_logged_late_is_only_warned_about() -> None:
    u_V, y_um = measured("proportional", "fig5")
    y_um = y_um + 1e-3 * np.random.default_rng(5).normal(size=y_um.size)
    late = 90  # samples; the stage itself lags by 50
    record = Record.from_arrays(u_V[:-late], y_um[late:], TS_S)
    assert len(record.warnings) == 1
    assert "or the voltage was logged late" in record.warnings[0]


@pytest.mark.parametrize("phase_rad", [0.0, 1.6, 3.2, 4.8])
def test_strong_disturbance_near_the_drive_does_not_make_the_columns_look_exchanged(phase_rad: float) -> None:
    k = np.arange(5000)
    u_V = 50 + 40 * np.sin(2 * np.pi * k / 500)
    y_um = 0.1 * u_V + 2.5 * np.sin(1.1 * 2 * np.pi * k / 500 + phase_rad)
    # At 4.8 rad the loops enclose -14 % in sum, but three of ten are run through the right way.
    assert Record.from_arrays(u_V, y_um, 1e-3).warnings == ()


def play(u: np.ndarray, width: float) -> np.ndarray:
    y = np.empty_like(u)
    state = u[0]
    for k, value in enumerate(u):
        state = y[k] = min(max(state, value - width), value + width)
    return y


@pytest.mark.parametrize("shape", ["sine", "triangle"])
@pytest.mark.parametrize("late", [0, 3, 15])
@pytest.mark.parametrize("step_um", [0.0, 0.01, 0.1])
def test_a_play_without_noise_at_its_turning_points_is_no_saturated_sensor(
    shape: str, late: int, step_um: float
) -> None:
    phase = np.arange(2000) / 200
    wave = np.sin(2 * np.pi * phase) if shape == "sine" else 4 * np.abs(phase % 1 - 0.5) - 1
    y_um = np.roll(0.1 * play(50 * wave, 10.0), late)
    y_um = np.round(y_um / step_um) * step_um if step_um else y_um
    assert Record.from_arrays((50 * wave)[late:], y_um[late:], 1e-3).warnings == ()
    assert not at_end([Segment("0", (50 * wave)[late:], y_um[late:], {})])[0].any()


def test_slow_sensor_that_repeats_its_values_is_no_sensor_at_its_end() -> None:
    u_V, y_um = measured("laboratory", "non-harmonic")
    held = np.repeat(y_um[::10], 10)[: y_um.size]
    (line,) = Record.from_arrays(u_V, held, TS_S).warnings
    assert "take every 10th row" in line
    assert not at_end([Segment("0", u_V, held, {})])[0].any()


def ahead(phase_rad: float, cycles: int = 6, noise: float = 0.0) -> list[tuple[str, bool, str]]:
    """The finding of exchanged columns for a displacement that leads a sine by this phase."""
    turn = 2 * np.pi * np.arange(200 * cycles + 1) / 200
    u_V = np.sin(turn) + noise * np.random.default_rng(1).normal(size=turn.size)
    return list(swapped([Segment("0", u_V, np.sin(turn + phase_rad), {})]))


def test_exchanged_columns_enclose_a_hundredth_of_the_path_and_correlate() -> None:
    """An ellipse of phase p encloses 2 pi sin p over a path of 4 sqrt 2, and has the correlation cos p."""
    limit = np.arcsin(0.01 * 4 * np.sqrt(2) / (2 * np.pi))
    assert [len(ahead(share * limit)) for share in (-1.1, 0.9, 1.1)] == [0, 0, 1]
    assert [len(ahead(np.arccos(correlation))) for correlation in (0.71, 0.69)] == [1, 0]
    # The first cycle begins before the record: of four, two are whole, of three, one.
    assert [len(ahead(0.3, cycles)) for cycles in (4, 3)] == [1, 0]
    (name, certain, line), (_, noisy, _) = ahead(0.3)[0], ahead(0.3, noise=1e-3)[0]
    assert (name, certain, noisy) == ("swapped", False, True)
    assert "displacement_um runs ahead of voltage_V in 4 cycles; " in line
