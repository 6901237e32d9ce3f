"""One module a verb, each with `arguments(parser)` and `run(arguments, console) -> exit code`; its docstring is the help."""

from types import ModuleType

VERBS: tuple[ModuleType, ...] = ()
