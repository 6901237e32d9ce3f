"""The published JSON Schemas: of the JSON of each verb, of model files and of manifests (docs/json.md).

`NAME-VERSION.json` beside this module, JSON Schema draft 2020-12. A schema names the keys that are always there and the
types of all known keys; further keys may come within a version.
"""

from importlib import resources

from hysgen.errors import HysgenError


def names() -> list[str]:
    """The names of all schemas with their versions, as `score-1`."""
    folder = resources.files(__package__)
    return sorted(entry.name.removesuffix(".json") for entry in folder.iterdir() if entry.name.endswith(".json"))


def text_of(name: str) -> str:
    """The text of the schema `score` (its newest version), `score-1` or `hysgen-score`. Raises HysgenError.

    `fit` writes a model, so its schema is that of the model file.
    """
    wanted = "model" if name == "fit" else name.removeprefix("hysgen-")
    versions = [stored for stored in names() if wanted in (stored, stored.rpartition("-")[0])]
    if not versions:
        raise HysgenError(f"{name}: no such schema; choose from {', '.join(names())}")
    newest = max(versions, key=lambda stored: int(stored.rpartition("-")[2]))
    return (resources.files(__package__) / f"{newest}.json").read_text(encoding="utf-8")
