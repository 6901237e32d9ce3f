"""Frama-C Eva: no run-time error, no NaN or infinity, and the state stays in its box, for every input and for ever."""
