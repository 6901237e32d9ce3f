"""One module a verb: `arguments(parser)`, `run(arguments, console) -> exit code`, and a docstring that is its help."""

from types import ModuleType

from hysgen.cli.verbs import (
    bank,
    cost,
    demo,
    describe,
    diagnose,
    diff,
    endurance,
    experiments,
    firmware,
    fit,
    generate,
    image,
    prove,
    refit,
    score,
    track,
    verify,
)

VERBS: tuple[ModuleType, ...] = (
    fit,
    score,
    describe,
    diagnose,
    generate,
    verify,
    prove,
    cost,
    refit,
    diff,
    demo,
    experiments,
    bank,
    endurance,
    image,
    firmware,
    track,
)
