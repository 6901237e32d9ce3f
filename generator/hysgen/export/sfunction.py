"""Simulink: a C MEX S-function with a masked block, and a MEX gateway for MATLAB and Octave."""

from __future__ import annotations

import tempfile
from pathlib import Path

from hysgen.export.base import Export, Samples, Words, output_of, results
from hysgen.model.disturbances import channels_of
from hysgen.model.model import Model

README = """\
    {{ name }}_make(true)     % MATLAB: builds {{ name }}_sfun and {{ name }}_mex, opens a model with the masked block
    make octave            # Octave: builds {{ name }}_mex and runs {{ name }}_example.m
    make check             # no MATLAB: the S-function against standin/simstruc.h

Ports carry their units. State is DWork, so Simulink's save and restore of simulation state works. **MATLAB and
Simulink were not run**: the S-function is compiled and run against the stand-in, the MEX gateway in Octave. The
Simulink block is not inlined (no TLC file); code generation for a target needs support for non-inlined S-functions.
"""


def run_standin(model: Model, folder: Path, samples: Samples) -> Words:
    """The S-function under the stand-in of simstruc.h."""
    output_of(["make", "-s", "standin/run"], folder)
    program = (folder / "standin" / "run").resolve()
    return results(output_of([str(program), *samples.start], folder, samples.rows.tobytes()))


def run_octave(model: Model, folder: Path, samples: Samples) -> Words:
    """The MEX gateway in Octave."""
    row = 3 + len(channels_of(model.terms))
    mode, y0_um, u0_V = samples.start
    with tempfile.TemporaryDirectory(prefix="hysgen-") as scratch:
        Path(scratch, "in.bin").write_bytes(samples.rows.tobytes())
        script = (
            f"addpath('{folder.resolve()}'); if ~exist('{model.name}_mex'), {model.name}_make(); rehash(); end\n"
            f"f = fopen('in.bin'); rows = fread(f, [{row}, Inf], 'uint32=>uint32'); fclose(f);\n"
            "g = @(r) reshape(typecast(reshape(r, [], 1), 'single'), size(r));\n"
            f"[result, status] = {model.name}_mex({mode}, single([{y0_um}, "
            f"{u0_V}]), g(rows(1, :)), g(rows(2, :)), g(rows(3:{row - 1}, :)), rows({row}, :));\n"
            "f = fopen('out.bin', 'w');"
            " fwrite(f, [typecast(result, 'uint32')'; status'; status'], 'uint32'); fclose(f);\n"
        )
        output_of(["octave-cli", "--no-gui", "--quiet", "--eval", script], Path(scratch))
        return results(Path(scratch, "out.bin").read_bytes())


EXPORT = Export(
    "sfunction",
    "Simulink S-function and MEX gateway",
    files={
        "{name}_sfun.c": "sfunction.c",
        "{name}_mex.c": "mex.c",
        "{name}_make.m": "sfunction_make.m",
        "{name}_example.m": "sfunction_example.m",
        "Makefile": "sfunction_Makefile",
        "standin/simstruc.h": "simstruc.h",
        "standin/cg_sfun.h": "cg_sfun.h",
        "standin/run.c": "standin.c",
    },
    readme=README,
    ways={"S-function": run_standin, "Octave": run_octave},
)
