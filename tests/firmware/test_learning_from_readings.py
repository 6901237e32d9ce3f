"""What the learner gets: the sensor's own readings, the voltage that was put out, and never a stand-in."""

from dataclasses import replace

import numpy as np
import pytest

from fixtures.firmware_bench import REFERENCE_UM, ModelStage, extended_image, model, on_itself, sine
from hysgen.firmware.wire import FirmwareStatus, Settings, State
from hysgen_lab.firmware.host import BoardFault, HostFirmware
from hysgen_lab.firmware.reference_models import extended

LEARNING = Settings(learn=True)


def wrong_nm(firmware: HostFirmware) -> float:
    """Largest change of an active parameter, as displacement over the whole range of its regressor, in nm."""
    controller = firmware.firmware.controller
    active, start = controller.model.bank[controller.model.active], controller.bank.rules
    changed = [
        reach * (now - before)
        for name, reach in (("slope", model().grid.y_max_um), ("offset", 1.0), ("gain", model().u_max_V))
        for now, before in zip(getattr(active, name), getattr(start, name), strict=True)
    ]
    return 1e3 * max(abs(each) for each in changed)


@pytest.mark.parametrize("value", [np.nan, np.inf, 14.0], ids=["NaN", "infinite", "out of range"])
def test_readings_that_are_none_reach_the_learner_as_none(value: float) -> None:
    """Every 10th reading is bad, on a stage that is the model itself: committed parameters stay within the noise."""
    firmware = on_itself(LEARNING)
    before = firmware.firmware.controller.learner.rejected
    firmware.fail(BoardFault.READING, value, after=1, pattern=(1, 10))
    firmware.run(sine(40_000))
    assert firmware.state is State.TRACK
    assert firmware.status & (FirmwareStatus.SENSOR_INVALID | FirmwareStatus.SENSOR_RANGE)
    assert firmware.firmware.controller.learner.rejected - before == 4000
    assert firmware.firmware.commits > 0
    # The readings' noise is 0.1 nm; with the last good reading in place of a bad one the change is 0.8 nm.
    assert wrong_nm(firmware) < 0.1


def test_a_sample_inside_a_commit_teaches_nothing_and_the_learners_path_goes_on_with_the_stage() -> None:
    """The same readings with and without a commit under way for 100 samples; none begins by itself."""
    states = []
    for committing in (0, 1):
        firmware = HostFirmware(extended_image(), ModelStage(extended()), Settings(learn=True))
        firmware.start(REFERENCE_UM)
        controller = firmware.firmware.controller
        firmware.run(sine(500))
        updates, controller.committing = controller.learner.updates, committing
        firmware.run(sine(100))
        ffi = firmware.image.library.ffi
        path = bytes(ffi.buffer(ffi.addressof(controller.learner, "inputs")))
        states.append((path, controller.learner.u_V, controller.learner.mean_u_V))
        assert (controller.learner.fresh, controller.learner.updates == updates) == (not committing, bool(committing))
    assert states[0] == states[1]
    assert FirmwareStatus.LEARN_SKIPPED in firmware.status


def test_the_voltage_is_put_out_before_the_learner_runs() -> None:
    firmware = on_itself(LEARNING)
    learner, told = firmware.firmware.controller.learner, []
    firmware.stage.watch = lambda u_V: told.append((u_V, learner.u_V))
    firmware.run(sine(500))
    put_out, known = np.array(told).T
    assert (known[1:] == put_out[:-1]).all()
    assert (known != put_out).any()


def test_the_learner_gets_the_voltage_that_was_put_out_not_the_one_that_was_wanted() -> None:
    """The rate limit acts at every second sample or so."""
    firmware = on_itself(replace(LEARNING, step_V=0.05, ramp_V=0.02, follow_um=0.49))
    learner, told = firmware.firmware.controller.learner, []
    firmware.stage.watch = lambda u_V: told.append((u_V, learner.u_V))
    firmware.run(sine(2000, 200.0))
    assert FirmwareStatus.OUTPUT_SLEWED in firmware.status
    put_out, known = np.array(told).T
    assert (known[1:] == put_out[:-1]).all()
