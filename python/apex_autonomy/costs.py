"""Costs of ignorance: the score of any plan, and user-defined costs, as functions or as tables for planners."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from apex_autonomy._apex import InputError, cost_points, expected_cost_of

__all__ = ["Cost", "ExpectedCost", "TargetCost", "cost_table", "expected_cost"]

Cost = Callable[[float], float]
"""The cost of not knowing of an event, as a function of its age in seconds; it never falls with age."""


@dataclass(frozen=True, slots=True)
class TargetCost:
    """The cost of one target over the mission.

    Attributes
    ----------
    expected_cost : float
        Its expected cost of ignorance.
    observations : int
        How often it was observed.
    longest_gap_s : float
        The longest span without an observation, in seconds.
    """

    expected_cost: float
    observations: int
    longest_gap_s: float


@dataclass(frozen=True, slots=True)
class ExpectedCost:
    """Expected cost of ignorance of a plan.

    Attributes
    ----------
    total : float
        The sum over all targets.
    targets : dict of str to TargetCost
        Each target in the problem's order.
    """

    total: float
    targets: dict[str, TargetCost]


def _visit(visit: Any) -> tuple[str, float]:
    try:
        target, end_s = visit["target"], float(visit["end_s"])
    except (TypeError, KeyError, ValueError) as error:
        raise InputError(f"a visit is {visit!r}, which has no `target` and `end_s`: {error!r}") from error
    if not isinstance(target, str):
        raise InputError(f"a visit is {visit!r}, whose `target` is not a name")
    return target, end_s


def _visits(visits: Mapping[str, Any] | Iterable[Mapping[str, Any]]) -> list[tuple[str, float]]:
    inner: Any = visits
    for member in ("plan", "Surveillance", "visits"):
        if isinstance(inner, Mapping) and member in inner:
            inner = inner[member]
    if isinstance(inner, str | Mapping) or not isinstance(inner, Iterable):
        raise InputError("the visits are neither a plan of surveillance nor a list of dicts with `target` and `end_s`")
    return [_visit(visit) for visit in inner]


def _own(target: str, cost: Cost | tuple[Cost, Iterable[float]]) -> tuple[str, Cost, list[float]]:
    function, jumps_s = cost if isinstance(cost, tuple) else (cost, ())
    if not callable(function):
        raise InputError(f"the cost of {target} is {function!r}, which cannot be called with an age")
    return target, function, [float(age_s) for age_s in jumps_s]


def expected_cost(
    problem: dict[str, Any] | str,
    visits: Mapping[str, Any] | Iterable[Mapping[str, Any]],
    *,
    costs: Mapping[str, Cost | tuple[Cost, Iterable[float]]] | None = None,
    survival: bool = False,
) -> ExpectedCost:
    """Score any plan of surveillance, from any planner, by the expected cost of ignorance.

    Whether the plan can be flown is not checked; :func:`plan` and its planners do that.

    Parameters
    ----------
    problem : dict or str
        A problem of surveillance in the form accepted by :func:`plan`.
    visits : mapping or iterable of mapping
        A result of :func:`plan`, its ``plan``, or visits in any order, each with its ``target`` and ``end_s``, the
        second at which its observation ends. Observations that end after the horizon do not count.
    costs : mapping of str to callable, optional
        For each named target, ``cost(age_s) -> float``, which replaces the cost in the problem. It is integrated by
        adaptive quadrature; ``(cost, ages_s)`` also gives the ages at which it jumps or has a kink, and needs fewer
        calls.
    survival : bool, default False
        Count only the first event after an observation, weighted with the probability that no other came before it.
        Otherwise likelihoods are added up as in the paper and as in planners and bounds; the two results agree if two
        events between two observations are rare.

    Returns
    -------
    ExpectedCost
        The total and each target's part.

    Raises
    ------
    PlanningError
        The problem cannot be read or is invalid.
    InputError
        A visit or cost for an unknown target; or a cost that raises, returns no number, is negative, not finite, or
        falls between evaluated ages. The text names the target and the age.

    Examples
    --------
    >>> from apex_autonomy import expected_cost
    >>> barn = {"name": "barn", "position": {"latitude_deg": 37.4, "longitude_deg": -121.1}, "dwell_s": 10}
    >>> barn |= {"rate": {"steps": [[0, 0.001]]}, "cost": {"Linear": {"cost_per_s": 2}}, "initial_age_s": 0}
    >>> travel = {"from_start_s": [60], "between_s": [[0]], "to_base_s": []}
    >>> problem = {"targets": [barn], "travel": travel, "horizon_s": 600, "return_to_base": False}
    >>> visits = [{"target": "barn", "end_s": 300}]
    >>> score = expected_cost({"Surveillance": problem}, visits)
    >>> round(score.total, 9), score.targets["barn"].observations
    (180.0, 1)
    >>> score = expected_cost({"Surveillance": problem}, visits, costs={"barn": lambda age_s: age_s**2 / 100})
    >>> round(score.total, 9)
    180.0
    >>> round(expected_cost({"Surveillance": problem}, visits, survival=True).total, 3)
    163.273
    """
    text = problem if isinstance(problem, str) else json.dumps(problem)
    own = [_own(target, cost) for target, cost in (costs or {}).items()]
    total, targets = expected_cost_of(text, _visits(visits), own, survival)
    rows = {name: TargetCost(cost, observations, gap_s) for name, cost, observations, gap_s in targets}
    return ExpectedCost(total, rows)


def cost_table(cost: Cost, *, horizon_s: float, relative_error: float = 1e-4) -> dict[str, Any]:
    """Put a user-defined cost into a table that planners can use, as the ``cost`` of a target in a problem.

    The cost must never fall with age. Then at every age up to `horizon_s` the error of the table is at most
    `relative_error` of the cost, or of a thousandth of the cost at `horizon_s` if that is more; jumps are found to a
    part in 10^12 of `horizon_s`. So the error of the expected cost of every plan is at most `relative_error` of itself
    plus of a thousandth of the expected cost if each event cost as much as the oldest one. This is proven by adding
    ages until neighbouring costs are close enough. A fall between two evaluated ages is not detected, and then nothing
    is guaranteed.

    Parameters
    ----------
    cost : callable
        ``cost(age_s) -> float``, not negative, never falling.
    horizon_s : float
        The oldest age that can occur: the sum of the problem's horizon and the target's initial age. Beyond it the
        table is constant.
    relative_error : float
        A smaller error needs more points and calls: up to 320 points and 230,000 calls for 1e-4 and smooth costs.

    Returns
    -------
    dict
        ``{"Table": {"points": [[age_s, cost], ..]}}``, at most 1,000 points.

    Raises
    ------
    InputError
        The cost raises, returns no number, is negative, not finite or falls; the text names the age. Also if too many
        points or calls are needed.

    Examples
    --------
    >>> from apex_autonomy import cost_table
    >>> cost_table(lambda age_s: 2.0 * age_s, horizon_s=3600)
    {'Table': {'points': [[0.0, 0.0], [3600.0, 7200.0]]}}
    """
    if not callable(cost):
        raise InputError(f"the cost is {cost!r}, which cannot be called with an age")
    return {"Table": {"points": [list(point) for point in cost_points(cost, horizon_s, relative_error)]}}
