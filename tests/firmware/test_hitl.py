"""The report that a user with one board sends back, on the host's board with a wire from the D/A to the A/D."""

import importlib.util
from pathlib import Path

import pytest

from fixtures.firmware_bench import Direct, ModelStage, image, model
from hysgen.firmware.link import Client
from hysgen_lab.firmware.host import HostFirmware

SPEC = importlib.util.spec_from_file_location("report", Path(__file__).resolve().parents[2] / "hitl/board_report.py")


class Wire(ModelStage):
    """Codes of the A/D are 0.999 times those of the D/A, and 12 more; a converter's noise of half a code."""

    def step(self, _: object, u_V: float) -> float:
        """The reading of a voltage."""
        code = 0.999 * (65535 * (u_V + 20) / 140 - 32767.5) + 12
        return -3.276 + 16.3837 * (code + 32767.5) / 65535 + next(self._noise_um)


def test_the_loop_back_finds_gain_zero_and_delay_of_the_converters() -> None:
    assert SPEC is not None
    assert SPEC.loader is not None
    report = importlib.util.module_from_spec(SPEC)
    SPEC.loader.exec_module(report)
    firmware = HostFirmware(image(), Wire(model(), 1.25e-4))
    client = Client(Direct(firmware, samples=2000))
    found = report.loop_back(client)
    assert (found["delay"], found["invalid"], found["good"]) == (1.0, 0, True)
    assert found["gain"] == pytest.approx(0.999, abs=1e-5)
    assert found["zero"] == pytest.approx(12.0, abs=0.1)
    assert found["rms"] == pytest.approx(0.58, abs=0.05), "noise and the rounding to codes"
    assert report.at_rest(client, lambda _: None)["status"]["selftest"] == 0
