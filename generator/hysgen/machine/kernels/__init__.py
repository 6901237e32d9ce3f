"""Compiled float64 kernels for recurrences that would take minutes in Python.

Each C file beside this one is written by hand in float64 and shares no code with the generated float32 C, which is
tested against it. `hysgen.machine.native` compiles a file once per machine and keeps the library in its cache.

    operators     limiters, plays, linear states, Preisach and Duhem columns, filters
    run           the model over a record
    estimation    recursive and orthogonal least squares, Kalman innovations
"""

from __future__ import annotations

from hysgen.machine.kernels.estimation import innovation_gains, innovations, rls_updates, triangularise
from hysgen.machine.kernels.operators import (
    Branch,
    HysteresisSeries,
    LinearPart,
    PreisachBasis,
    duhem_columns,
    hysteresis_inverse,
    hysteresis_path,
    lag_of_signals,
    lag_states,
    lag_sums,
    linear_response,
    linear_response_rows,
    mode_states,
    play_operators,
    preisach_columns,
    preisach_path,
    slew_limited,
)
from hysgen.machine.kernels.run import (
    FreeRunSums,
    HorizonInputs,
    Rules,
    free_run,
    free_run_sums,
    horizon_errors,
    one_step,
    rule_rows,
)

__all__ = [
    "Branch",
    "FreeRunSums",
    "HorizonInputs",
    "HysteresisSeries",
    "LinearPart",
    "PreisachBasis",
    "Rules",
    "duhem_columns",
    "free_run",
    "free_run_sums",
    "horizon_errors",
    "hysteresis_inverse",
    "hysteresis_path",
    "innovation_gains",
    "innovations",
    "lag_of_signals",
    "lag_states",
    "lag_sums",
    "linear_response",
    "linear_response_rows",
    "mode_states",
    "one_step",
    "play_operators",
    "preisach_columns",
    "preisach_path",
    "rls_updates",
    "rule_rows",
    "slew_limited",
    "triangularise",
]
