"""Folders that bring a model into other tools, found by listing the modules of this package.

An export is an `Export` that a module there defines: its templates, its build and the ways to run it. Each folder
holds the generated C in model/, the files of the export, a build and an example. `export_texts` returns the texts;
`write_export` writes them, and compiles what the folder ships as a binary.
"""

import functools
import importlib
import pkgutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from hysgen.codegen import Options, generate, in_quantities, write
from hysgen.errors import HysgenError, nearest
from hysgen.export.base import Draft, Export, Written, component_facts
from hysgen.model.model import Model
from hysgen.model.path import preview

__all__ = ["Export", "export_of", "export_texts", "exports", "write_export"]


@functools.lru_cache(maxsize=1)
def exports() -> Mapping[str, Export]:
    """Every export by its name, that of `--to`. Raises ValueError if two have the same name."""
    registry: dict[str, Export] = {}
    for module in sorted(entry.name for entry in pkgutil.iter_modules(__path__)):
        held = vars(importlib.import_module(f"{__name__}.{module}")).values()
        for export in (item for item in held if isinstance(item, Export)):
            if registry.setdefault(export.name, export) is not export:
                raise ValueError(f"{module}: the name {export.name!r} belongs to another export")
    return dict(sorted(registry.items()))


def export_of(name: str) -> Export:
    """The export of this name. Raises HysgenError if there is none."""
    if name not in exports():
        raise HysgenError(f"{name}: is no target{nearest(name, exports())}; choose from {', '.join(exports())}")
    return exports()[name]


def export_texts(model: Model, name: str, options: Options | None = None) -> dict[str, str]:
    """The text of every file of the folder, by its path there; what is built from them is not among them.

    Raises HysgenError for an unknown export, and the errors of `generate`.
    """
    return _texts(export_of(name), _draft(model, export_of(name), options))


def write_export(
    model: Model, name: str, folder: Path, options: Options | None = None, given: Mapping[str, str] | None = None
) -> list[Path]:
    """Write the folder of an export, with its binaries. Returns the paths in the order of writing.

    given: values of the export's own options. Raises the errors of `export_texts`, and BuildError where a compiler is
    missing or an option does not fit the model.
    """
    export = export_of(name)
    draft = _draft(model, export, options)
    texts = _texts(export, draft)
    write(texts, folder)
    values = {option.name: "" for option in export.options} | dict(given or {})
    return [folder / path for path in (*texts, *export.finish(Written(draft, folder, texts, values)))]


def _draft(model: Model, export: Export, options: Options | None) -> Draft:
    chosen = options or Options()
    facts = {**component_facts(model, chosen), "target": export.name, "title": export.title, "runs": bool(export.ways)}
    facts["preview"] = preview(model.blocks) if chosen.inverse else 0
    draft = Draft(model, chosen, generate(model, chosen), facts)
    return replace(draft, facts={**facts, **export.facts(draft)})


def _texts(export: Export, draft: Draft) -> dict[str, str]:
    texts = {f"model/{file}": text for file, text in draft.generated.items()}
    texts |= draft.rendered(export.files)
    texts |= export.sources(draft)
    texts |= {"README.md": draft.readme(export.readme)} if export.readme else {}
    named = set(draft.generated.values())  # in the model's quantities, wherever the export copies them
    return {path: text if text in named else in_quantities(draft.model, path, text) for path, text in texts.items()}
