"""The data of the commit's templates: struct, return values, checks and parameter sections."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hysgen.certify.certificates import Certificates
from hysgen.codegen.parameters import Constant, Section, Table
from hysgen.codegen.render import Feature
from hysgen.codegen.structs import candidate_struct, rows, rule_axis
from hysgen.float32.coefficients import Coefficients
from hysgen.float32.commit_numbers import CommitNumbers, commit_numbers
from hysgen.float32.learner_status import COMMIT_MEANINGS, PHASE_MEANINGS, Commit, Phase
from hysgen.model.model import Model
from hysgen.model.structs import Axis, Quantity


def commit_feature(model: Model, numbers: Coefficients, certificates: Certificates) -> Feature | None:
    """The generated commit of a model with learner settings; None for a model without.

    Raises CertificateError if the parameters of the model itself violate a limit of the commit.
    """
    if model.learner is None:
        return None
    found = commit_numbers(model, numbers, certificates)
    upper = model.name.upper()
    facts = {
        "answer_rows": _enumerators(f"{upper}_COMMIT", COMMIT_MEANINGS),
        "phase_rows": _enumerators(f"{upper}_PHASE", PHASE_MEANINGS),
        "members": rows(candidate_struct(model, numbers).members),
        "bias": "bias" in model.learner.learned,
        "points_per_call": model.learner.points_per_call,
    }
    return Feature("commit.c.j2", {"commit": facts}, _sections(found, upper, rule_axis(model)))


def _enumerators(prefix: str, meanings: Mapping[Commit, str] | Mapping[Phase, str]) -> list[str]:
    """One C line per enumerator, comments in an aligned column."""
    texts = [f"{prefix}_{key.name} = {int(key)}" + "," * (key is not list(meanings)[-1]) for key in meanings]
    wide = max(len(text) for text in texts)
    return [f"{text:<{wide}}  /**< {meaning} */" for text, meaning in zip(texts, meanings.values(), strict=True)]


def _sections(found: CommitNumbers, upper: str, axis: Axis) -> list[Section]:
    constants = [
        Constant("COMMIT_MATURE", np.uint32(found.settings.mature)),
        Constant("COMMIT_HALF_UM", found.half_um),
        Constant("COMMIT_GAIN_REMAINDER", found.gain_remainder),
        Constant("COMMIT_SLOPE_REMAINDER_1", found.slope_remainder_1),
        Constant("COMMIT_SLOPE_REMAINDER_3", found.slope_remainder_3),
        Constant("COMMIT_SIGN", found.sign),
        Constant("COMMIT_GAIN_FLOOR", found.gain_floor),
        Constant("COMMIT_GAIN_CEILING", found.gain_ceiling),
        Constant("COMMIT_SLOPE_LIMIT", found.slope_limit),
    ]
    tables = [
        Table("commit_unfold", f"{upper}_RULES", found.unfold, Quantity("1 / strength of each rule"), axis),
        Table("commit_y", f"{found.points}", found.y_um, Quantity("check points", "um")),
        Table(
            "commit_table",
            f"{found.table.size}",
            found.table.ravel(),
            Quantity("memberships and their first two derivatives over the strengths, at each check point"),
        ),
    ]
    checks = Section("Commit: check points.", [Constant("COMMIT_POINTS", np.uint32(found.points))], public=True)
    limits = Section(
        "Commit: half the distance h of the check points; what Taylor's theorem leaves, h^2/2 times bounds of the\n"
        "memberships' second and third derivatives; limits of |b(y)| [um/V] and |df/dy|; rows of p_l, p_l', p_l''\n"
        "over the strengths w_l at each check point.",
        constants,
        tables,
    )
    return [checks, limits]
