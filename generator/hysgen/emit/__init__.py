"""C from a model: `generate` is pure and returns text, `write` puts it into a folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from hysgen.coefficients import Coefficients, coefficients
from hysgen.emit.concerns import Concern
from hysgen.emit.learning import learner_concern
from hysgen.emit.parameters import block_sections, range_section, rule_section, term_sections
from hysgen.emit.render import context, render
from hysgen.files import write_whole
from hysgen.model import Model

__all__ = ["Options", "generate", "write"]


@dataclass(frozen=True)
class Options:
    """What is generated besides init, predict and simulate."""

    inverse: bool = True


# Each gives its concern, or None if the options do not ask for it; in the order of the generated text.
CONCERNS: list[Callable[[Model, Coefficients, Options], Concern | None]] = [learner_concern]


def generate(model: Model, options: Options | None = None) -> dict[str, str]:
    """File name -> text of everything that goes to the firmware."""
    chosen = options or Options()
    numbers = coefficients(model)
    upper = model.name.upper()
    concerns = [concern for build in CONCERNS if (concern := build(model, numbers, chosen)) is not None]
    sections = [range_section(numbers), rule_section(numbers, upper), *block_sections(model)]
    sections += term_sections(model, numbers, upper)
    facts = context(model, numbers) | {
        "inverse": chosen.inverse,
        "concerns": concerns,
        "sections": [*sections, *(section for concern in concerns for section in concern.sections)],
    }
    for concern in concerns:
        facts |= concern.facts
    return {
        f"{model.name}.h": render("header.h.j2", facts),
        f"{model.name}.c": render("source.c.j2", facts),
        f"{model.name}_params.h": render("params.h.j2", facts),
    }


def write(texts: Mapping[str, str], folder: Path) -> None:
    """Write every text into `folder`, each file whole or not at all."""
    for name, text in texts.items():
        write_whole(folder / name, text)
