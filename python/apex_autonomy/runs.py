"""Series of flights: the results of a mission over many seeds, and the causes of losses."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from apex_autonomy import _apex
from apex_autonomy._apex import InputError
from apex_autonomy._arguments import SEED_MAX, seed_of, whole
from apex_autonomy.flight import Mission
from apex_autonomy.planner import Planner, means

__all__ = ["Runs", "fly_runs"]

#: The limits of the command ``apex fly --runs``.
RUNS_MAX, JOBS_MAX = 1_000_000, 1_024


@dataclass(frozen=True)
class Runs:
    """The flights of a series.

    Attributes
    ----------
    rows : list of dict
        One for each flight in the order of the seeds: ``seed``, ``outcome`` (``"completed"``, ``"lost"``, ``"error"``),
        ``reason``, ``end_s``, ``score`` and ``benefits`` (points) or ``expected_cost`` (of ignorance), ``fires``,
        ``fires_seen``, ``realised_cost`` and ``expected_cost_stated`` where a world file has ignitions,
        ``observed`` (visits that ended, and targets observed without a visit), ``left_out``, ``reflies``, ``plans``,
        and positions checked and violating requirements: ``positions``,
        ``inside_zones``, ``outside_permitted``, ``near_ground``, ``beyond_landing_distance``, ``said_broken``;
        ``not_landed``, what is known of a vehicle that is not on the ground at the end; and ``ended_early``, true if
        the program ended the flight before its initial task was done (1 or 0 in a table).
    summary : dict
        ``runs``, ``completed``, ``measure``, ``quantiles`` (0, 5, 25, 50, 75, 95 and 100 %), ``mean``, ``ignorance``
        (realised next to expected), ``violations`` by kind, ``lost`` and ``ended_early`` by reason.
    text : str
        The summary as text.
    """

    rows: list[dict[str, Any]]
    summary: dict[str, Any]
    text: str


def fly_runs(
    mission: Mission,
    *,
    runs: int,
    jobs: int = 1,
    seed: int | None = None,
    until_s: float | None = None,
    out: str | Path | None = None,
    planners: Iterable[Planner] = (),
    table: str | None = None,
    solver_timeout_s: float | None = None,
    solver_memory_mib: int | None = None,
    on_progress: Callable[[int], object] | None = None,
) -> Runs:
    """Fly a mission many times in the built-in simulator, each in a world with the next seed. No record is written.

    Ctrl-C or an exception of `on_progress` ends the series after the flights under way, and is raised then.

    Parameters
    ----------
    mission : Mission
        The mission.
    runs : int
        Number of flights.
    jobs : int, optional
        Number of flights at the same time. The rows do not depend on it.
    seed : int, optional
        Seed of the first flight; left out, the mission's.
    until_s : float, optional
        Mission time at which a flight ends at the latest.
    out : str or path, optional
        Table of the flights, ``.parquet`` or ``.csv``, with a column for each member of a row. It is opened before the
        first flight; a file that exists keeps its content until the series has ended.
    planners, table, solver_timeout_s, solver_memory_mib
        As of :func:`fly`; the memory is multiplied by `jobs`.
    on_progress : callable, optional
        Called with the number of flights flown after each one.

    Raises
    ------
    InputError
        A number is out of range.
    MissionError
        No flights or no jobs, the mission cannot be simulated, or the table cannot be written. A flight that fails is a
        row with its reason.

    Examples
    --------
    >>> from apex_autonomy import Mission, fly_runs
    >>> series = fly_runs(Mission.load("../missions/first-picture"), runs=3, seed=7)
    >>> [(row["seed"], row["outcome"]) for row in series.rows]
    [(7, 'completed'), (8, 'completed'), (9, 'completed')]
    """
    resources = means(planners, table=table, solver_timeout_s=solver_timeout_s, solver_memory_mib=solver_memory_mib)
    ends = (until_s, None if out is None else Path(out))
    series = (seed_of(seed), whole("runs", runs, 0, RUNS_MAX), whole("jobs", jobs, 0, JOBS_MAX))
    if seed is not None and seed + runs - 1 > SEED_MAX:
        raise InputError(f"`seed` is {seed}: the seed of the last of {runs} runs is beyond {SEED_MAX}")
    answer = json.loads(_apex.fly_runs_json(mission._native, series, ends, resources, on_progress))
    return Runs(rows=answer["runs"], summary=answer["summary"], text=answer["summary_text"])
