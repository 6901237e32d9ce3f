"""The way through hysgen for scripts and notebooks; `import hysgen` has all of it at the top.

record = hysgen.load_record("record.csv")
study = hysgen.diagnose(record)             # what the simulation gets wrong, and why
model = study.model                         # or hysgen.fit(record, plays=12)
code = hysgen.generate(model)               # the C, as text
hysgen.verify(code)                         # equal bits
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path

from hysgen.c674x.cost import Cost, cost_of_texts
from hysgen.certify.certificates import certify
from hysgen.checking.bits import verify_texts
from hysgen.checking.bits.report import Report
from hysgen.codegen import Options, write
from hysgen.codegen import generate as generate_texts
from hysgen.codegen.manifest import read_folder
from hysgen.diagnosis import DiagnoseSettings
from hysgen.diagnosis.evaluation import Study, diagnose_and_evaluate
from hysgen.display import Displayed, Summary
from hysgen.errors import HysgenError
from hysgen.fitting import FitSettings
from hysgen.fitting import fit as fit_model
from hysgen.model.file import load_model, save_model
from hysgen.model.model import Model
from hysgen.model.scores import Scores, score
from hysgen.model.terms.memory import Memory
from hysgen.record import Columns, Record, load_record
from hysgen.report.words import price_of

__all__ = [
    "Columns",
    "Cost",
    "DiagnoseSettings",
    "FitSettings",
    "Generated",
    "HysgenError",
    "Model",
    "Options",
    "Record",
    "Report",
    "Scores",
    "Study",
    "cost",
    "diagnose",
    "fit",
    "generate",
    "load_model",
    "load_record",
    "save_model",
    "score",
    "verify",
]

Progress = Callable[[float, str], None]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Generated(Displayed):
    """Generated files: the model and file name -> text. `code["stage.h"]` is one of them."""

    model: Model
    texts: Mapping[str, str]

    def __getitem__(self, name: str) -> str:
        return self.texts[name]

    def write(self, folder: str | Path) -> Path:
        """Write every file into a folder, each whole or not at all."""
        write(self.texts, Path(folder))
        return Path(folder)

    def summary(self) -> Summary:
        """The files and their sizes."""
        rows = [[name, f"{len(text.splitlines())}", f"{len(text.encode())}"] for name, text in self.texts.items()]
        return Summary(f"C of model {self.model.name}: {len(self.texts)} files", ["file", "lines", "bytes"], rows)


def fit(
    record: Record, settings: FitSettings | None = None, *, plays: int = 0, progress: Progress | None = None
) -> Model:
    """A model of a record: the paper's, with the free run refined, or as `settings` say.

    plays: add memory of so many play operators, half-widths up to half the record's voltage range.
    Raises FitError or RecordError with one line.
    """
    chosen = settings or FitSettings()
    if plays > 0:
        low_V, high_V = record.u_range_V
        terms = (*chosen.terms, Memory.uniform(plays, 0.5 * (high_V - low_V)))
        chosen = dataclasses.replace(chosen, terms=terms)
    return fit_model(record, chosen, progress=progress)


def diagnose(
    record: Record,
    holdout: Record | None = None,
    settings: DiagnoseSettings | None = None,
    progress: Progress | None = None,
) -> Study:
    """What the simulation of a record gets wrong, why, and what an extended model gains and costs.

    Structure and numbers come from `record` alone (without `holdout` from its first 65 %); scores are held out.
    Raises RecordError or FitError with one line.
    """
    chosen = settings or DiagnoseSettings()
    if chosen.price is None:
        chosen = dataclasses.replace(chosen, price=price_of)
    return diagnose_and_evaluate(record, holdout, chosen, progress)


def generate(model: Model, options: Options | None = None) -> Generated:
    """The C of a model, in memory; with the inverse where that is certified, unless `options` say otherwise.

    Raises CertificateError or BudgetError with place and value.
    """
    chosen = options or Options(inverse=certify(model).inverse_holds)
    return Generated(model, generate_texts(model, chosen))


def verify(code: Generated | str | Path, samples: int = 200_000, progress: Progress | None = None) -> Report:
    """Compare generated C, or a folder of it, with its reference, bit for bit, in every build that is possible here.

    Raises HysgenError if the folder is not complete or there is no compiler.
    """
    if isinstance(code, Generated):
        return verify_texts(code.model, code.texts, samples=samples, structures=0, progress=progress)
    folder = read_folder(Path(code))
    return verify_texts(
        folder.model, folder.texts, samples=samples, structures=0, progress=progress, altered=folder.altered
    )


def cost(code: Generated | str | Path) -> Cost:
    """What generated C, or a folder of it, costs: operations, cycles against the sample period, bytes."""
    if isinstance(code, Generated):
        return cost_of_texts(code.model, code.texts, timed=False)
    folder = read_folder(Path(code))
    return cost_of_texts(folder.model, folder.texts, timed=False)
