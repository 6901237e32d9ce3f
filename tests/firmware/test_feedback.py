"""The model's feedback in the firmware: no wind-up at the limits of the output, whatever the sign of the gain."""

from dataclasses import replace

import numpy as np
import pytest

from fixtures.firmware_bench import ModelStage, model
from hysgen.firmware import firmware_model
from hysgen.firmware.wire import Settings, State
from hysgen.model.model import Model
from hysgen_lab.firmware.host import HostFirmware, HostImage

LOW_V, HIGH_V = 22.0, 56.0
LOOPED = Settings(loop=True, low_V=0.0, high_V=60.0, follow_um=0.49)


def narrowed() -> Model:
    """Appendix A over the inputs LOW_V .. HIGH_V."""
    return replace(model(), u_min_V=LOW_V, u_max_V=HIGH_V)


def mirrored() -> Model:
    """The same with LOW_V + HIGH_V - u in place of u: its gain is negative."""
    q1, q2, q3 = narrowed().consequents.T
    return replace(narrowed(), consequents=np.stack([q1, -q2, q3 + q2 * (LOW_V + HIGH_V)], axis=1))


def started(driven: Model, settings: Settings, reference_um: float) -> HostFirmware:
    stage = ModelStage(driven)
    firmware = HostFirmware(HostImage.compile(driven.name, firmware_model(driven)), stage, settings)
    firmware.start(reference_um)
    assert firmware.state is State.TRACK
    return firmware


def test_a_model_without_feedback_is_driven_by_feed_forward_alone() -> None:
    logs = []
    for driven, loop in ((model(), False), (replace(model(), feedback=None), True)):
        firmware = started(driven, Settings(loop=loop), 2.0)
        logs.append(firmware.run(2.0 + 0.5 * np.sin(0.01 * np.arange(1000))))
    assert np.array_equal(logs[0].output_V, logs[1].output_V)


def reached_um(driven: Model, u_V: float) -> float:
    """Displacement at rest under u_V."""
    stage = ModelStage(driven, noise_um=0.0)
    for _ in range(2000):
        stage.step(None, u_V)
    return stage.y_um


@pytest.mark.parametrize("driven", [narrowed, mirrored], ids=lambda each: each.__name__)
@pytest.mark.slow
def test_a_drift_that_comes_and_goes_at_the_end_of_the_range_leaves_nothing_behind(driven: object) -> None:
    """While the drift lasts the output rests at its limit; afterwards the feedback must let go of it."""
    plant = driven()  # type: ignore[operator]
    lowest_um = min(reached_um(plant, LOW_V), reached_um(plant, HIGH_V))
    reference_um = lowest_um + 0.08
    firmware = started(plant, LOOPED, reference_um)
    firmware.stage.sensor = lambda y_um: y_um + 0.2  # type: ignore[attr-defined]
    firmware.run(np.full(5000, reference_um))
    firmware.stage.sensor = lambda y_um: y_um  # type: ignore[attr-defined]
    log = firmware.run(np.full(5000, reference_um))
    assert abs(float(log.reading_um[-500:].mean()) - reference_um) < 1e-3


@pytest.mark.parametrize("driven", [narrowed, mirrored], ids=lambda each: each.__name__)
@pytest.mark.parametrize("limits_V", [{"high_V": 45.0}, {"low_V": 33.0, "off_V": 33.0}], ids=str)
@pytest.mark.slow
def test_limits_of_the_settings_inside_the_models_range_do_not_wind_up(
    driven: object, limits_V: dict[str, float]
) -> None:
    plant = driven()  # type: ignore[operator]
    settings = replace(LOOPED, loop_low_V=34.0, loop_high_V=44.0, **limits_V)
    limit_V = next(iter(limits_V.values()))
    limit_um, middle_um = reached_um(plant, limit_V), reached_um(plant, 39.0)
    firmware = started(plant, settings, middle_um)
    beyond_um = limit_um + 0.2 * np.sign(limit_um - middle_um)
    firmware.run(np.full(4000, beyond_um))
    assert firmware.board.output_V == limit_V
    # The residual before the limit is reached may stay; what builds up at the limit may not.
    assert abs(firmware.firmware.controller.model.loop.correction_um) < 0.1
