"""The bank: records of virtual stages that hide effects, and how often the diagnosis finds what was hidden.

The analysis sees only the record. What counts as hidden is decided by the plant, run with and without each effect.
"""

from hysgen.studies.bank.judge_records import run
from hysgen.studies.bank.limits import Limit, limits, limits_table
from hysgen.studies.bank.result import BankResult, Verdict
from hysgen.studies.bank.scenario import CATEGORIES, Scenario, scenario

__all__ = ["CATEGORIES", "BankResult", "Limit", "Scenario", "Verdict", "limits", "limits_table", "run", "scenario"]
