"""A sensor that drifts while feedback and learning follow it: told before the stage is further off than is allowed."""

# Safety case: [S5]

from collections.abc import Callable

import numpy as np
import pytest

from fixtures.firmware_bench import ModelStage, extended_image, image, model, sine
from hysgen.firmware.wire import FirmwareStatus, Settings, State
from hysgen.model.path import preview
from hysgen_lab.firmware.host import HostFirmware
from hysgen_lab.firmware.reference_models import extended

WRONG_UM = 0.1
RATE_HZ = 50_000
TOLD_WITHIN = 0.35
"""Share of the drift after which each must have been told: 0.08 um are 3 % of the range, and drift reaches 50 %."""

Sensor = Callable[[float, float, list[float]], float]
SENSORS: dict[str, Sensor] = {
    "x 0.5": lambda y_um, share, _: (1.0 - 0.5 * share) * y_um,
    "x 1.5": lambda y_um, share, _: (1.0 + 0.5 * share) * y_um,
    "offset": lambda y_um, share, _: y_um + 1.0 * share,
    "delay": lambda _, share, past: past[-1 - int(200 * share)],
}


def drifted(name: str, settings: Settings, sensor: Sensor, seconds: float) -> tuple[HostFirmware, float]:
    """The firmware once it has tripped, or TOLD_WITHIN of the drift is over; the largest error of the stage in um."""
    driven, built = (model(), image()) if name == "appendix_a" else (extended(), extended_image())
    stage = ModelStage(driven)
    firmware = HostFirmware(built, stage, settings)
    references, ahead = sine(RATE_HZ // 5), preview(driven.blocks) + 1
    firmware.start(float(references[0]))
    true_um, past = list[float](), [stage.y_um] * 201
    total = seconds * RATE_HZ

    def read(y_um: float) -> float:
        true_um.append(y_um)
        past.append(y_um)
        return sensor(y_um, min(1.0, len(true_um) / total), past)

    stage.sensor = read
    wrong_um = 0.0
    for _ in range(int(TOLD_WITHIN * total / references.size) + 1):
        before = len(true_um)
        log = firmware.run(references)
        tracked = int((log.state == State.TRACK).sum())
        # The reading behind voltage k is that of sample k + 1, for which reference k + 1 - ahead was given.
        error_um = np.array(true_um[before + ahead : before + tracked]) - references[1 : 1 + max(0, tracked - ahead)]
        wrong_um = max(wrong_um, float(np.abs(error_um).max(initial=0.0)))
        del past[:-201]
        if firmware.state is not State.TRACK:
            break
    return firmware, wrong_um


CASES = [
    pytest.param(name, sensor, seconds, marks=[pytest.mark.slow] * (seconds > 20 or name == "extended"))
    for name in ("appendix_a", "extended")
    for sensor in SENSORS
    for seconds in (20.0, 120.0)
] + [
    pytest.param("appendix_a", sensor, 1200.0, marks=[pytest.mark.slow, pytest.mark.proof])
    for sensor in ("x 0.5", "offset")
]


@pytest.mark.parametrize(("name", "sensor", "seconds"), CASES)
def test_a_drifting_sensor_is_told_before_the_stage_is_a_tenth_of_a_micrometre_wrong(
    name: str, sensor: str, seconds: float
) -> None:
    settings = Settings(loop=True, learn=True)
    firmware, wrong_um = drifted(name, settings, SENSORS[sensor], seconds)
    assert FirmwareStatus.FAULT_FOLLOW in firmware.status
    assert wrong_um < WRONG_UM
    assert firmware.state is not State.TRACK
