"""One module a verb: `arguments(parser)`, `run(arguments, console) -> exit code`, and a docstring that is its help."""

from types import ModuleType

from hysgen.cli.verbs import describe, experiments, fit, generate, score

VERBS: tuple[ModuleType, ...] = (fit, score, describe, generate, experiments)
