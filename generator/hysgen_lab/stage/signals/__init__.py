"""Driving voltages as arrays: the signals of the paper, and excitations for identification."""

from hysgen_lab.stage.signals.excitation import nested_amplitudes, plateaus
from hysgen_lab.stage.signals.joining import SignalError, joined, largest_jump, safe
from hysgen_lab.stage.signals.paper import Part, fig5, fig8, fig11_non_harmonic, fig11_sine, tracking_reference

__all__ = [
    "Part",
    "SignalError",
    "fig5",
    "fig8",
    "fig11_non_harmonic",
    "fig11_sine",
    "joined",
    "largest_jump",
    "nested_amplitudes",
    "plateaus",
    "safe",
    "tracking_reference",
]
