"""The measured record dbo/ramps.csv: fitted on its first 5000 rows, scored in free run on the rest, beside the rivals.

Run:  HYSGEN_DATA=/folder/of/the/records python benchmarks/measured_ramps.py
"""

from __future__ import annotations

import os
from pathlib import Path

from hysgen.certify.certificates import certify
from hysgen.display import table
from hysgen.fitting import FitSettings, Method, PathSize, fit
from hysgen.model.rivals import fit_rivals, score_rivals
from hysgen.model.scores import score
from hysgen.record import load_record

ROWS_TO_FIT = 5000
UNSCORED = 300
CASES: tuple[tuple[str, Method, PathSize | None], ...] = (
    ("6 rules, Eq. (10)", "rls", None),
    ("6 rules, batch", "batch", None),
    ("6 rules, refined", "refined", None),
    ("with memory, one lag", "batch", PathSize()),
    ("with memory, refined", "refined", PathSize()),
)


def main() -> None:
    """Print one table in um rms, and the certificates of each model."""
    known, fresh = load_record(Path(os.environ["HYSGEN_DATA"]) / "dbo" / "ramps.csv").split_at(ROWS_TO_FIT)
    rows, certificates = [], []
    for label, method, memory in CASES:
        model = fit(known, FitSettings(method=method, memory=memory))
        found = score(model, fresh)
        knowing = score(model, fresh, UNSCORED).own
        values = (found.one_step.e_rms_um, found.free_run.e_rms_um, knowing.e_rms_um)
        rows.append([label, *(f"{value:.4f}" for value in values)])
        certificates += [f"{label}: {line}" for line in certify(model).lines()]
        persistence, noise = found.persistence.e_rms_um, found.noise
    rows.append(["persistence", f"{persistence:.4f}", "", ""])
    for label, rival in score_rivals(fit_rivals(known), fresh):
        rows.append([label, "", f"{rival.e_rms_um:.4f}", ""])
    print(f"{fresh.source}: {fresh.samples} samples, noise floor {noise.describe()}")
    print(table(["um rms", "one step", "free run", "free run, own"], rows))
    print("\n".join(certificates))


if __name__ == "__main__":
    main()
