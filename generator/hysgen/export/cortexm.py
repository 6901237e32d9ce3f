"""A Cortex-M4F: start-up, linker script and a program that qemu runs."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from hysgen.export.base import Export, Samples, Words, output_of, results
from hysgen.model.model import Model

README = """\
    make run               # arm-none-eabi-gcc and qemu-system-arm: the self-test, and input.bin if there is one

A Cortex-M4F of qemu (mps2-an386). For a board of your own keep `model/` and {{ name }}_component.c and replace
start.c, link.ld and main.c. Its cycles are **unknown**: qemu does not count them, and the estimates in
model/{{ name }}.h are of the C674x. Measure with the cycle counter (DWT->CYCCNT) and state your figures: `hysgen
generate MODEL --clock HZ --budget CYCLES --cycles predict=N,...`.
"""


def run_cortexm(model: Model, folder: Path, samples: Samples) -> Words:
    """The program under qemu."""
    output_of(["make", "-s", f"{model.name}.elf"], folder)
    start = np.array([samples.y0_um, samples.u0_V], np.float32)
    header = np.array([samples.mode.number], np.uint32).tobytes() + start.tobytes()
    machine = ["-machine", "mps2-an386", "-display", "none", "-serial", "none", "-monitor", "none"]
    semihosting = ["-semihosting-config", "enable=on,target=native"]
    kernel = str((folder / f"{model.name}.elf").resolve())
    with tempfile.TemporaryDirectory(prefix="hysgen-") as scratch:
        Path(scratch, "input.bin").write_bytes(header + samples.rows.tobytes())
        output_of(["qemu-system-arm", *machine, *semihosting, "-kernel", kernel], Path(scratch))
        return results(Path(scratch, "output.bin").read_bytes())


EXPORT = Export(
    "cortexm",
    "Cortex-M example",
    files={
        "main.c": "cortexm_main.c",
        "start.c": "cortexm_start.c",
        "link.ld": "cortexm_link.ld",
        "Makefile": "cortexm_Makefile",
    },
    readme=README,
    ways={"Cortex-M qemu": run_cortexm},
)
