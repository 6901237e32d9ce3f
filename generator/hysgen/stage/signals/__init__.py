"""Driving voltages as arrays: the signals of the paper, and excitations for identification."""

from hysgen.stage.signals.excitation import chirp, multisine, nested_amplitudes, plateaus, reversal_curves
from hysgen.stage.signals.joining import SignalError, joined, largest_jump, safe
from hysgen.stage.signals.paper import Part, fig5, fig8, fig11_non_harmonic, fig11_sine, tracking_reference

__all__ = [
    "Part",
    "SignalError",
    "chirp",
    "fig5",
    "fig8",
    "fig11_non_harmonic",
    "fig11_sine",
    "joined",
    "largest_jump",
    "multisine",
    "nested_amplitudes",
    "plateaus",
    "reversal_curves",
    "safe",
    "tracking_reference",
]
