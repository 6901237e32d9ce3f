"""Compiled float64 kernels for recurrences that would take minutes in Python.

Each C file beside this one is written by hand in float64 and shares no code with the generated float32 C, which is
tested against it. `hysgen.machine.native` compiles a file once per machine and keeps the library in its cache.

    operators     limiters, plays, linear states, Preisach and Duhem columns, filters
    run           the model over a record
    estimation    recursive and orthogonal least squares, Kalman innovations
"""
