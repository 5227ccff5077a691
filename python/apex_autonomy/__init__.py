"""Apex, the autonomy executive, for Python.

A :class:`Monitor` watches one condition of PDL over samples and messages, and tells every way in which it comes true:

>>> from apex_autonomy import Monitor
>>> monitor = Monitor("(rssi modem < 20)")
>>> monitor.push(12.5, 17)[0].start_s
12.5

A :class:`Planner` is a planner of your own; :func:`plan` plans with it, :func:`apex` flies missions with it.
:func:`expected_cost` scores any plan of surveillance, also by costs of your own, and :func:`cost_table` makes them
tables for planners.

Words and meaning are those of PDL (``docs/reference/conditions.md``); nothing is decided here.
"""

from apex_autonomy._apex import (
    ApexError,
    ConditionError,
    Evidence,
    InputError,
    Interval,
    Judgement,
    PlanningError,
    Quantity,
    Reason,
    Result,
    Results,
    Symbol,
    Variable,
    __version__,
)
from apex_autonomy.costs import ExpectedCost, TargetCost, cost_table, expected_cost
from apex_autonomy.monitor import Monitor
from apex_autonomy.planner import Environment, Planner, apex, plan
from apex_autonomy.tables import to_arrow

__all__ = [
    "ApexError",
    "ConditionError",
    "Environment",
    "Evidence",
    "ExpectedCost",
    "InputError",
    "Interval",
    "Judgement",
    "Monitor",
    "Planner",
    "PlanningError",
    "Quantity",
    "Reason",
    "Result",
    "Results",
    "Symbol",
    "TargetCost",
    "Variable",
    "__version__",
    "apex",
    "cost_table",
    "expected_cost",
    "plan",
    "to_arrow",
]
