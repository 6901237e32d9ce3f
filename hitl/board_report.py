"""What one board says of itself, as a file to send back.

    python hitl/board_report.py PORT -o report.json [--loop-back]

hitl/README.md says how to wire it. Needs pyserial (pip install 'hysgen[link]').
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hysgen.firmware.link import BAUD, Client, open_line
from hysgen.firmware.wire import FirmwareStatus, Request, State

TOP_V, SECONDS = 40.0, 1.2
"""Height of the loop-back's triangles, and the time of the table."""
DELAYS = range(4)


def at_rest(client: Client, wait: Callable[[float], None] = time.sleep, pause_s: float = 10.0) -> dict[str, Any]:
    """Identity, status, and the rate of the samples by this computer's clock, to a few milliseconds of `pause_s`."""
    identity, began = client.identity(), time.monotonic()
    first = client.status()
    wait(pause_s)
    second, seconds = client.status(), time.monotonic() - began
    rate_Hz = (second.samples - first.samples) / seconds
    return {
        "identity": vars(identity),
        "status": vars(second) | {"state": State(second.state).name, "bits": FirmwareStatus(second.status).name},
        "samples_per_second": rate_Hz,
        "good": second.selftest == 0 and abs(rate_Hz * identity.period_ns * 1e-9 - 1.0) < 0.01,
    }


def loop_back(client: Client) -> dict[str, Any]:
    """The D/A wired to the A/D: triangles, and the line from code to code that fits best.

    gain: codes of the A/D per code of the D/A. zero: codes of the A/D, from its middle, at the middle of the D/A. rms,
    worst: what the line leaves, in codes of the A/D. delay: samples from the voltage to the reading. invalid: readings
    that were none.
    """
    identity = client.identity()
    client.request(Request.CLEAR)
    times_s = np.linspace(0.0, SECONDS, 5)
    _, voltage_V, reading_um = client.record(times_s, np.array([0.0, TOP_V, 0.0, TOP_V, 0.0]))
    out = 65535.0 * (voltage_V - identity.low_V) / (identity.high_V - identity.low_V) - 32767.5
    back = 65535.0 * (reading_um - identity.low_um) / (identity.high_um - identity.low_um) - 32767.5
    lines = []
    for delay in DELAYS:
        u, y = out[: out.size - delay], back[delay:]
        valid = np.isfinite(y)
        gain, zero = np.polyfit(u[valid], y[valid], 1)
        left = y[valid] - gain * u[valid] - zero
        lines.append({"delay": delay, "gain": gain, "zero": zero, "rms": left.std(), "worst": np.abs(left).max()})
    best = min(lines, key=lambda line: line["rms"])
    status = client.status()
    found = {name: float(value) for name, value in best.items()}
    return found | {
        "samples": int(out.size),
        "invalid": int(np.isnan(reading_um).sum()),
        "cycles_most": status.cycles_most,
        "bits": FirmwareStatus(status.status).name,
        "good": best["delay"] == 1 and abs(best["gain"] - 1.0) < 0.01 and best["rms"] < 4.0,
    }


def main() -> int:
    """Write the report; 1 if a part of it is not good."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("port")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--baud", type=int, default=BAUD)
    parser.add_argument(
        "--loop-back", action="store_true", help="the D/A is wired to the A/D, the amplifier is not there"
    )
    chosen = parser.parse_args()
    report: dict[str, Any] = {"computer": platform.platform(), "python": sys.version.split()[0]}
    with Client(open_line(chosen.port, chosen.baud)) as client:
        report["at_rest"] = at_rest(client)
        if chosen.loop_back:
            report["loop_back"] = loop_back(client)
    text = json.dumps(report, indent=2)
    Path(chosen.output).write_text(text + "\n", encoding="utf-8")
    print(text)
    return int(not all(part["good"] for part in report.values() if isinstance(part, dict)))


if __name__ == "__main__":
    sys.exit(main())
