"""Apex, the autonomy executive, for Python.

A :class:`Monitor` watches one condition of PDL over samples and messages, and returns all ways in which it comes true:

>>> from apex_autonomy import Monitor
>>> monitor = Monitor("(rssi modem < 20)")
>>> monitor.push(12.5, 17)[0].start_s
12.5

:func:`fly` flies a :class:`Mission` in the built-in simulator and records it, :func:`fly_runs` flies many seeds;
:func:`replay`, :func:`fork` and :func:`report` work on the record. A :class:`Planner` is a user-defined planner:
:func:`plan` plans with it, missions are flown with it, and a :class:`Profile` measures it with those that ship.
:func:`expected_cost` scores any plan of surveillance, also by user-defined costs, and :func:`cost_table` turns such
costs into tables for planners.

Syntax and meaning are those of PDL (``docs/reference/conditions.md``); this package only translates.
"""

from apex_autonomy._apex import (
    ApexError,
    ConditionError,
    ConditionStatus,
    Evidence,
    InputError,
    Interval,
    MissionError,
    PlanningError,
    Quantity,
    Reason,
    RecordWarning,
    Result,
    Results,
    Symbol,
    Variable,
    __version__,
)
from apex_autonomy.costs import ExpectedCost, TargetCost, cost_table, expected_cost
from apex_autonomy.flight import (
    Difference,
    Flight,
    Mission,
    Plan,
    ReplayResult,
    Report,
    Target,
    fly,
    fork,
    replay,
    report,
    trace,
)
from apex_autonomy.monitor import Monitor
from apex_autonomy.planner import Environment, Planner, plan, problem
from apex_autonomy.profile import Profile, profile_cells
from apex_autonomy.runs import Runs, fly_runs
from apex_autonomy.tables import to_arrow

#: The former name of :class:`ConditionStatus`; kept for one release.
Judgement = ConditionStatus

__all__ = [
    "ApexError",
    "ConditionError",
    "ConditionStatus",
    "Difference",
    "Environment",
    "Evidence",
    "ExpectedCost",
    "Flight",
    "InputError",
    "Interval",
    "Judgement",
    "Mission",
    "MissionError",
    "Monitor",
    "Plan",
    "Planner",
    "PlanningError",
    "Profile",
    "Quantity",
    "Reason",
    "RecordWarning",
    "ReplayResult",
    "Report",
    "Result",
    "Results",
    "Runs",
    "Symbol",
    "Target",
    "TargetCost",
    "Variable",
    "__version__",
    "cost_table",
    "expected_cost",
    "fly",
    "fly_runs",
    "fork",
    "plan",
    "problem",
    "profile_cells",
    "replay",
    "report",
    "to_arrow",
    "trace",
]
