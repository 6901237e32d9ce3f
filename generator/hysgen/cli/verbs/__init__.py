"""One module a verb: `arguments(parser)`, `run(arguments, console) -> exit code`, and a docstring that is its help."""

from types import ModuleType

VERBS: tuple[ModuleType, ...] = ()
