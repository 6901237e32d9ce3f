"""A diagnosis as a terminal shows it: the verdict first, then what it rests on."""

from __future__ import annotations

from hysgen.certify.certificates import certify
from hysgen.diagnosis.study import Study
from hysgen.display import table
from hysgen.report.words import CONFIDENCE, ladder_header, ladder_rows, parameter_text, verdict, where_rows


def diagnosis_text(study: Study) -> str:
    """Verdict, ladder, evidence, where the error lies, and what to measure next."""
    found, record = study.diagnosis, study.record
    blocks = [
        f"{record.source}: {study.cut} rows to identify; scores are of the {record.samples - study.cut} held out",
        "\n".join(verdict(study)),
        table(ladder_header(), ladder_rows(study)) + f"\nnoise floor from {found.noise.source}"
        "; gain: fall of the rms, block bootstrap; of the error: share of its power above the noise"
        + (f"\n{CONFIDENCE}" if study.extended else ""),
    ]
    evidence = [f"{cause.name}: {cause.evidence}{_parameters(study, cause.name)}" for cause in found.causes]
    evidence += [f"not named: {refused.name}: {refused.why}" for refused in found.refused]
    if evidence:
        blocks.append("\n".join(evidence))
    header = ["error rms by", "paper's model", *(["extended"] if study.improved else [])]
    blocks.append(table(header, where_rows(study), left=3))
    blocks.append("\n".join([f"model of {len(found.model.parameters)} parameters", *certify(found.model).lines()]))
    if found.next_experiment:
        blocks.append(f"next experiment: {found.next_experiment}")
    return "\n\n".join(blocks)


def _parameters(study: Study, name: str) -> str:
    text = parameter_text(study, name)
    return f" ({text})" if text else ""
