"""The one contract that Eva takes on trust, held against every float there is by running the generated C."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Mapping

from hysgen.checking.proof.eva.frama import Verdict
from hysgen.checking.proof.sources import folder_of
from hysgen.codegen.render import render
from hysgen.errors import BuildError


def check_contract(name: str, texts: Mapping[str, str]) -> Verdict:
    """Run `<name>_beyond` on all 2^32 floats. Raises BuildError if gcc is not installed or refuses the C."""
    started = time.monotonic()
    program = render("proof/contract.c.j2", {"name": name, "NAME": name.upper()})
    with folder_of({**texts, "contract.c": program}) as scratch:
        call = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", "-o", "contract", "contract.c"]
        try:
            built = subprocess.run(call, cwd=scratch, capture_output=True, text=True, check=False)
        except FileNotFoundError as fault:
            raise BuildError("gcc: not installed; apt-get install gcc") from fault
        if built.returncode != 0:
            raise BuildError(f"gcc: contract.c: {(built.stderr.strip().splitlines() or ['refused'])[0]}")
        run = subprocess.run([str(scratch / "contract")], capture_output=True, text=True, check=False)
    alarms = () if run.returncode == 0 else (f"contract does not hold: {run.stdout.strip() or run.returncode}",)
    return Verdict(alarms, 1 - len(alarms), 1, time.monotonic() - started)
