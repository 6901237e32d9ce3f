"""The verbs of the command line. A module is imported when one of its verbs is used: some import most of SciPy."""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Callable
from dataclasses import dataclass

from hysgen.cli.console import Console

MODULES = {
    "fit": "fit",
    "score": "score",
    "describe": "score",
    "diagnose": "diagnose",
    "generate": "generate",
    "export": "export",
    "verify": "verify",
    "prove": "verify",
    "cost": "generate",
    "refit": "fit",
    "diff": "fit",
    "history": "history",
    "demo": "studies",
    "experiments": "studies",
    "bank": "studies",
    "endurance": "studies",
    "image": "firmware",
    "firmware": "firmware",
    "track": "firmware",
}
"""Module by verb, in the order of `hysgen --help`."""

NAMES = tuple(MODULES)


@dataclass(frozen=True)
class Verb:
    """help: text of `hysgen VERB --help`, its first line is the summary; run: does the work, returns the exit code."""

    help: str
    arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace, Console], int]


def verb(name: str) -> Verb:
    """The verb of this name; imports its module."""
    chosen: Verb = importlib.import_module(f"{__name__}.{MODULES[name]}").VERBS[name]
    return chosen
