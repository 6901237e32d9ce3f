"""The generated C equals the float32 reference in every bit: results, states, status words and counters."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hysgen.emit import generate
from hysgen.host import Host
from hysgen.model import Model
from hysgen.model_file import load_model
from hysgen.reference.instance import Instance
from hysgen.terms.memory import Memory


def with_plays() -> Model:
    base = load_model("appendix_a")
    return dataclasses.replace(base, terms=(Memory.uniform(5, 60.0),), weights=np.linspace(1e-4, 5e-4, 5))


@pytest.mark.parametrize("function", ["predict", "simulate", "inverse"])
def test_generated_c_equals_reference_bit_for_bit_sample_by_sample(function: str) -> None:
    model = with_plays()
    host = Host(model.name, generate(model))
    rng = np.random.default_rng(20240501)
    y = rng.uniform(0.3, 4.1, 2000).astype(np.float32)
    u = rng.uniform(-30.0, 130.0, 2000).astype(np.float32)
    y[::97], u[::89], y[5::101] = np.nan, np.inf, -np.inf
    inputs = {"predict": [y, u], "simulate": [u], "inverse": [y, np.roll(y, 1)]}[function]

    struct = host.instance(2.0, 30.0)
    layout = host.layout(f"{model.name}_t")
    words = layout["bank[0].slope[0]"]
    out, trace = host.run(function, struct, [column.view(np.uint32) for column in inputs], words=words)

    lane = Instance(model, np.full(1, 2.0, np.float32), np.full(1, 30.0, np.float32))
    for k in range(y.size):
        result = getattr(lane, function)(*(column[k : k + 1] for column in inputs))
        assert result.view(np.uint32)[0] == out[k], f"{function}: sample {k}"
        for place, (name, word) in enumerate(lane.words().items()):
            assert word[0] == trace[k, place + 1], f"{function}: {name} after sample {k}"
