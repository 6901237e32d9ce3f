"""One module a verb: `arguments(parser)`, `run(arguments, console) -> exit code`, and a docstring that is its help."""

from types import ModuleType

from hysgen.cli.verbs import bank, describe, diagnose, experiments, fit, generate, score, verify

VERBS: tuple[ModuleType, ...] = (fit, score, describe, diagnose, generate, verify, experiments, bank)
