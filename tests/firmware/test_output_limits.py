"""Limits of the output that act: model, learner and stage get the same voltage, whatever the limits leave of it."""

# Safety case: [S2]

import numpy as np
import pytest

from fixtures.firmware_bench import ModelStage, extended_image, image, model
from hysgen.firmware.wire import FirmwareStatus, Settings, State
from hysgen.model.path import preview
from hysgen_lab.firmware.host import FAULTS, HostFirmware
from hysgen_lab.firmware.reference_models import extended

CENTRE_UM = 2.0
NOISE_NM = 0.1


def started(name: str, settings: Settings) -> HostFirmware:
    """The image on a stage that is its own model, following CENTRE_UM."""
    driven, built = (model(), image()) if name == "appendix_a" else (extended(), extended_image())
    firmware = HostFirmware(built, ModelStage(driven, 1e-3 * NOISE_NM), settings)
    firmware.start(CENTRE_UM)
    assert firmware.state is State.TRACK
    return firmware


def triangle_um(samples: int, ahead: int) -> np.ndarray:
    """References of a triangle of 0.3 um at 100 Hz, `ahead` samples early."""
    turns = (np.arange(ahead, samples + ahead) * 100.0 * 20e-6 + 0.25) % 1.0
    return CENTRE_UM + 0.3 * (4.0 * np.abs(turns - 0.5) - 1.0)


def apart_nm(name: str, settings: Settings, references_um: np.ndarray) -> tuple[np.ndarray, HostFirmware]:
    """Displacement of the stage minus that of the firmware's own model at the same sample, in nm, and the firmware."""
    firmware = started(name, settings)
    ahead = preview(extended().blocks) + 1 if name == "extended" else 1
    controller, stage = firmware.firmware.controller, firmware.stage
    pairs: list[tuple[float, float]] = []
    stage.watch = lambda _: pairs.append((stage.y_um, controller.model.y_um))  # type: ignore[attr-defined]
    firmware.run(references_um)
    stage_um, model_um = np.array(pairs).T
    return 1e3 * (stage_um[ahead:] - model_um[:-ahead]), firmware


@pytest.mark.parametrize("step_V", [1.5, 0.5, 0.1])
def test_model_and_stage_stay_the_same_to_the_bit_while_the_rate_limit_acts(step_V: float) -> None:
    """With the wished voltage in the model's state instead they were 13.6 nm apart (rms, 0.25 V per sample)."""
    settings = Settings(step_V=step_V, follow_um=0.49, reference_step_um=0.5)
    error_nm, firmware = apart_nm("appendix_a", settings, triangle_um(4000, 1))
    assert FirmwareStatus.OUTPUT_SLEWED in firmware.status
    assert np.abs(error_nm).max() == 0.0


@pytest.mark.parametrize("range_V", [(0.0, 45.0), (30.0, 60.0)], ids=str)
def test_model_and_stage_stay_the_same_to_the_bit_while_the_range_of_the_output_acts(
    range_V: tuple[float, float],
) -> None:
    low_V, high_V = range_V
    loop = {"loop_low_V": 32.0, "loop_high_V": 44.0}
    settings = Settings(low_V=low_V, high_V=high_V, off_V=low_V, reference_step_um=0.5, **loop)
    wide_um = CENTRE_UM + 4.0 * (triangle_um(4000, 1) - CENTRE_UM)
    error_nm, firmware = apart_nm("appendix_a", settings, wide_um)
    assert FirmwareStatus.OUTPUT_LIMITED in firmware.status
    assert np.abs(error_nm).max() == 0.0


@pytest.mark.slow
def test_with_delay_hysteresis_and_creep_the_limits_leave_nothing_behind() -> None:
    """The delay of 1.8 samples needs the command to come; while the limit acts its error is that of one command."""
    for step_V, nm in ((1.5, 1.5), (0.25, 0.5)):
        settings = Settings(step_V=step_V, follow_um=0.49, reference_step_um=0.5)
        references_um = np.concatenate([triangle_um(8000, 3), np.full(2000, CENTRE_UM)])
        error_nm, firmware = apart_nm("extended", settings, references_um)
        assert FirmwareStatus.OUTPUT_SLEWED in firmware.status
        assert np.abs(error_nm).max() < nm
        assert np.abs(error_nm[-500:]).max() < 0.05


@pytest.mark.parametrize("name", ["appendix_a", "extended"])
@pytest.mark.slow
def test_a_reference_step_that_the_settings_allow_is_no_fault(name: str) -> None:
    firmware = started(name, Settings(step_V=0.25, reference_step_um=0.5))
    steps = np.repeat([2.0, 2.6, 1.4, 2.0], 3000)
    log = firmware.run(steps)
    assert firmware.state is State.TRACK
    assert not firmware.status & FAULTS
    assert FirmwareStatus.OUTPUT_SLEWED in firmware.status
    assert abs(float(log.reading_um[-500:].mean()) - CENTRE_UM) < 1e-3


def test_a_model_that_is_right_stays_right_while_it_learns_under_the_rate_limit() -> None:
    settings = Settings(learn=True, step_V=0.5, reference_step_um=0.5, follow_um=0.49)
    error_nm, firmware = apart_nm("appendix_a", settings, triangle_um(40_000, 1))
    assert FirmwareStatus.OUTPUT_SLEWED in firmware.status
    assert firmware.firmware.commits > 3
    # Noise of 0.1 nm and the rounding of committed parameters.
    assert np.abs(error_nm).max() < 0.5
