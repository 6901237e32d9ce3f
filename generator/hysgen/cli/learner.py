"""Options that say what the generated learner learns, and how."""

from __future__ import annotations

import argparse
import dataclasses

from hysgen.model.learner_settings import LEARNED, MOST_CALLS, LearnerSettings
from hysgen.model.model import Model


def add_learner_options(parser: argparse.ArgumentParser) -> None:
    """--learn and what goes with it."""
    defaults = LearnerSettings()
    group = parser.add_argument_group("online learning (docs/learning.md)")
    group.add_argument(
        "--learn",
        choices=(*LEARNED, "none"),
        help="parameters that the generated C learns: consequents of the rules, weights of the terms, all of them,"
        " one bias, or none (default: what the model file says)",
    )
    group.add_argument(
        "--learn-forgetting",
        type=float,
        metavar="LAMBDA",
        help=f"forgetting factor of the learner, 0.9 to 1 (default {defaults.forgetting})",
    )
    group.add_argument(
        "--learn-alpha",
        type=float,
        metavar="ALPHA",
        help=f"P(0) = alpha I of the learner; it starts from the identified parameters (default {defaults.alpha:g})",
    )
    group.add_argument(
        "--learn-noise",
        type=float,
        metavar="UM",
        help=f"rms noise of the sensor in um: sets dead zone and outlier gate (default {defaults.noise_um:g})",
    )
    group.add_argument(
        "--calls-per-update",
        type=int,
        metavar="N",
        help=f"spread one update over N calls, up to {MOST_CALLS} (default 1)",
    )


def with_learner(model: Model, arguments: argparse.Namespace) -> Model:
    """`model` with the learner that the options ask for; without options, as it is.

    Raises ModelError if a value is outside its range.
    """
    asked = {
        "forgetting": arguments.learn_forgetting,
        "alpha": arguments.learn_alpha,
        "noise_um": arguments.learn_noise,
        "calls_per_update": arguments.calls_per_update,
    }
    changes = {name: value for name, value in asked.items() if value is not None}
    if arguments.learn == "none":
        return dataclasses.replace(model, learner=None)
    if arguments.learn is not None:
        changes["learned"] = LEARNED[arguments.learn]
    elif not changes:
        return model
    return dataclasses.replace(model, learner=dataclasses.replace(model.learner or LearnerSettings(), **changes))
