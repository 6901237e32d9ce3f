"""Nanoseconds per sample of generated functions on this machine: the median of repeated runs over smooth inputs."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Final

import numpy as np

from hysgen.checking.bits.functions import SUBJECTS
from hysgen.checking.bits.inputs import chunks
from hysgen.checking.host import Host
from hysgen.model.model import Model

REPEATS: Final = 9
SAMPLES: Final = 1 << 14


def nanoseconds(host: Host, model: Model) -> Mapping[str, float]:
    """Time per sample of each step function that the header declares, in ns."""
    found = {}
    for subject in SUBJECTS:
        for function, arguments in subject.functions.items():
            if function not in host.entries or function == "init":
                continue
            heard = ["channel"] * host.channels if subject.listens else []
            columns = next(chunks(model, "smooth", [*arguments, *heard], SAMPLES, seed=1))
            struct = subject.start(host)
            times = []
            for _ in range(REPEATS):
                started = time.perf_counter_ns()
                host.run(function, struct, columns)
                times.append((time.perf_counter_ns() - started) / SAMPLES)
            found[function] = float(np.median(times))
    return found
