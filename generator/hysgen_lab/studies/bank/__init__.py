"""The bank: records of virtual stages with hidden effects, and how often the diagnosis names these effects.

The diagnosis is given the record alone. The size of a hidden effect is the change of the plant's output without it.
"""

from hysgen_lab.studies.bank.judge_records import Limit, limits, limits_table, run
from hysgen_lab.studies.bank.result import BankResult, Judgement
from hysgen_lab.studies.bank.scenario import CATEGORIES, OWN, Scenario, scenario

__all__ = [
    "CATEGORIES",
    "OWN",
    "BankResult",
    "Judgement",
    "Limit",
    "Scenario",
    "limits",
    "limits_table",
    "run",
    "scenario",
]
