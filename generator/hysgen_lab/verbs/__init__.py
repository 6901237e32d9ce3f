"""The verbs of `python -m hysgen_lab`. Their module is imported when one of them is used."""

import importlib

from hysgen.cli.verbs import Program, Verb


def verb(name: str) -> Verb:
    """The verb of this name; imports the module of the verbs."""
    chosen: Verb = importlib.import_module(f"{__name__}.studies").VERBS[name]
    return chosen


LABORATORY = Program(
    "python -m hysgen_lab",
    "Studies on virtual piezo stages: how often a diagnosis is right, the paper's experiments, the learner "
    "under poor excitation, the whole firmware in closed loop.",
    {
        "studies": {
            "experiments": ("studies", "the paper's experiments on the virtual stage"),
            "track": ("studies", "the complete firmware on the virtual stage"),
            "bank": ("studies", "how often a diagnosis of hidden effects is right"),
            "gallery": ("studies", "what each cause does to the virtual stage, in small pictures"),
            "endurance": ("studies", "the learner for hours of poor and broken excitation"),
        }
    },
    verb,
    below="`python -m hysgen_lab VERB --help` has the options. Exit codes: 0 done, 1 a limit is missed, 2 not done.",
)
