"""The verbs of the command line. A module is imported when one of its verbs is used: some import most of SciPy."""

import argparse
import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from hysgen.cli.console import Console
from hysgen.cli.outputs import Output

GROUPS: Mapping[str, Mapping[str, tuple[str, str]]] = {
    "look at a record, fit a model": {
        "inspect": ("inspect", "what a file holds: channels, units, rate, noise, excitation, what each cause needs"),
        "diagnose": ("diagnose", "what the simulation gets wrong, the causes, an extended model and its gain"),
        "experiment": ("diagnose", "the voltage to play next, for what a record cannot tell"),
        "fit": ("fit", "fit a model to one or several records"),
        "score": ("fit", "errors of a model: one step, against the horizon, in free run"),
        "compare": ("fit", "several models on the same records: the errors of each, the best"),
        "describe": ("fit", "a model as a dynamic system: time constant, gain, loop, certificates"),
    },
    "from a trajectory to a voltage": {
        "simulate": ("waveform", "the displacement of a model under the voltages of a file"),
        "waveform": ("waveform", "the voltage that takes the stage along a displacement, inside its limits"),
        "loop": ("waveform", "a feedback loop around the inverse of a model, with its certificate"),
    },
    "from the model to C": {
        "generate": ("generate", "the C of a model"),
        "export": ("generate", "the model for Simulink, FMI, A2L tools, CMake, any C program, a Cortex-M"),
        "verify": ("verify", "compare generated C with its reference, bit for bit"),
        "prove": ("verify", "warnings, MISRA rules, sanitizers, proofs of generated C"),
        "cost": ("generate", "operations, cycles and bytes of generated C"),
    },
    "later": {
        "refit": ("refit", "identify a model again from a new record: same structure, new numbers"),
        "diff": ("refit", "what changed from one model to another"),
        "image": ("firmware", "a model's numbers as a parameter image for running firmware"),
        "firmware": ("firmware", "the files that the firmware needs of a model, and the cost of its image"),
        "schema": ("schema", "the JSON Schema of the result of a verb, of a model file, of a manifest"),
        "link": ("firmware", "commands to running firmware: state, start, stop, reference, parameter images"),
    },
    "an example": {
        "demo": ("demo", "the whole way on the bundled record"),
    },
}
"""Module and summary of each verb, by group, in the order of the work and of `hysgen --help`."""

MODULES = {name: module for verbs in GROUPS.values() for name, (module, _) in verbs.items()}
"""Module by verb."""

NAMES = tuple(MODULES)


@dataclass(frozen=True)
class Verb:
    """help: text of `hysgen VERB --help`; run: does the work, returns the exit code; outputs: options that name files
    to write, by argument, beside those of `outputs.COMMON`; examples: command lines, shown below the options."""

    help: str
    arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace, Console], int]
    outputs: Mapping[str, Output] = field(default_factory=dict)
    examples: tuple[str, ...] = ()


@dataclass(frozen=True)
class Program:
    """A command with verbs: `hysgen`, or one beside it that shares its manners.

    groups: as GROUPS. verb: the verb of a name. first: commands to begin with, each with what it does; below: text at
    the end of the overview.
    """

    name: str
    description: str
    groups: Mapping[str, Mapping[str, tuple[str, str]]]
    verb: Callable[[str], Verb]
    first: Mapping[str, str] = field(default_factory=dict)
    below: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """Every verb, in the order of the overview."""
        return tuple(name for verbs in self.groups.values() for name in verbs)


def verb(name: str) -> Verb:
    """The verb of this name; imports its module."""
    chosen: Verb = importlib.import_module(f"{__name__}.{MODULES[name]}").VERBS[name]
    return chosen
