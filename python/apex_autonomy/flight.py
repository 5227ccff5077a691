"""Missions: planned, flown in the built-in simulator, replayed, and continued with changes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from apex_autonomy import _apex
from apex_autonomy._arguments import seed_of
from apex_autonomy.outcomes import Difference, Flight, Plan, ReplayResult, Report, Target
from apex_autonomy.planner import Planner, chosen, means

__all__ = [
    "Difference",
    "Flight",
    "Mission",
    "Plan",
    "ReplayResult",
    "Report",
    "Target",
    "fly",
    "fork",
    "replay",
    "report",
    "trace",
]


class Mission:
    """A mission, ready to plan and fly.

    Examples
    --------
    >>> from apex_autonomy import Mission
    >>> mission = Mission.load("../missions/structure-watch")
    >>> mission.name, mission.duration_s, len(mission.targets)
    ('Structure Watch', 3900.0, 18)
    """

    def __init__(self, native: _apex.Mission) -> None:
        self._native = native

    @staticmethod
    def load(path: str | Path) -> Mission:
        """Load the mission of a folder, or of a program file such as ``mission.pdl``.

        Raises
        ------
        MissionError
            The program has errors, or its data cannot be used.
        """
        return Mission(_apex.Mission.load(Path(path)))

    @property
    def name(self) -> str:
        """The mission's title."""
        return self._native.name

    @property
    def vehicle(self) -> str:
        """The name of the vehicle's model."""
        return self._native.vehicle

    @property
    def duration_s(self) -> float:
        """The mission time in seconds at which a flight ends at the latest."""
        return self._native.duration_s

    @property
    def seed(self) -> int:
        """Seed of the simulated world and of planners, unless another is given."""
        return self._native.seed

    @property
    def warnings(self) -> list[str]:
        """Warnings of the program, each with its place."""
        return self._native.warnings

    @property
    def targets(self) -> list[Target]:
        """Targets and named places."""
        return [Target(**target) for target in json.loads(self._native.targets_json)]

    def plan(
        self,
        *,
        planner: Planner | str | None = None,
        budget_s: float | None = None,
        seed: int | None = None,
        planners: Iterable[Planner] = (),
        table: str | None = None,
    ) -> Plan:
        """Plan from the start of the mission, without flying.

        Parameters
        ----------
        planner : Planner or str, optional
            A user-defined planner, or the name of a planner; by default the profile table selects one.
        budget_s : float, optional
            Time for deliberation, in the time of a flight; left out, that of the mission's first solver.
        seed : int, optional
            Seed of the planner's random numbers; left out, the mission's.
        planners : iterable of Planner
            User-defined planners that `planner` or `table` may name.
        table : str, optional
            Text of the profile table (`Profile.table`); by default the one that ships with Apex.

        Raises
        ------
        PlanningError
            There is no plan; the message states the reason.
        InputError
            A number is out of range, or the name of a planner is invalid or taken.

        Examples
        --------
        >>> from apex_autonomy import Mission
        >>> planned = Mission.load("../missions/structure-watch").plan(planner="nearest-neighbour", budget_s=0.01)
        >>> len(planned.problem["Surveillance"]["targets"])
        16
        >>> planned.answer["plan"]["Surveillance"]["solver"]
        'nearest-neighbour'
        """
        name, own = chosen(planner, planners)
        problem, answer = self._native.plan_json(name, budget_s, seed_of(seed), means(own, table=table))
        return Plan(json.loads(problem), json.loads(answer))


def fly(
    mission: Mission,
    *,
    record: str | Path,
    seed: int | None = None,
    until_s: float | None = None,
    pace: float | None = None,
    planners: Iterable[Planner] = (),
    table: str | None = None,
    solver_timeout_s: float | None = None,
    solver_memory_mib: int | None = None,
    on_progress: Callable[[float], object] | None = None,
) -> Flight:
    """Fly a mission in the built-in simulator and record it.

    Ctrl-C stops the flight; so does an exception of `on_progress`. The record is closed before the exception is raised.

    Parameters
    ----------
    mission : Mission
        The mission; it names planners by ``(solver NAME ..)``.
    record : str or Path
        The flight record to write; an older record there is replaced.
    seed : int, optional
        Seed of the simulated world; by default that of the mission.
    until_s : float, optional
        Mission time at which the flight ends at the latest.
    pace : float, optional
        Simulated seconds per second; by default as fast as possible, or 1 for missions of type ``realtime``.
    planners : iterable of Planner
        User-defined planners in addition to the planners that ship with Apex.
    table : str, optional
        Text of the profile table (`Profile.table`); by default the one that ships with Apex.
    solver_timeout_s : float, optional
        Wall time after which a planner that does not answer is abandoned; by default 5 minutes.
    solver_memory_mib : int, optional
        Growth of the program, in MiB, at which a planner is stopped; by default 1,024.
    on_progress : callable, optional
        Called with the mission time in seconds, at most once a minute of mission time.

    Raises
    ------
    MissionError
        The mission cannot be simulated, the flight fails, or the record cannot be written.
    InputError
        A number is out of range, or the name of a planner is invalid or taken.

    Examples
    --------
    >>> import tempfile
    >>> from apex_autonomy import Mission, fly
    >>> mission = Mission.load("../missions/first-picture")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     flight = fly(mission, record=f"{folder}/flight.apex", until_s=30)
    >>> flight.end_s
    30.0
    """
    answer = json.loads(
        _apex.fly_json(
            mission._native,
            Path(record),
            seed_of(seed),
            (until_s, pace),
            means(planners, table=table, solver_timeout_s=solver_timeout_s, solver_memory_mib=solver_memory_mib),
            on_progress,
        )
    )
    achieved = answer.pop("report")
    return Flight(record=Path(record), report=achieved["sections"], text=achieved["text"], **answer)


def replay(record: str | Path) -> ReplayResult:
    """Execute the recorded inputs again and compare every decision and every planning problem.

    Raises
    ------
    MissionError
        The record cannot be read, holds no steps, or was written by a version that reads its program differently.

    Warns
    -----
    RecordWarning
        The record is incomplete, was changed, is not as it was signed, or is of another version of Apex.
    """
    answer = json.loads(_apex.replay_json(Path(record)))
    difference = answer.pop("difference")
    return ReplayResult(difference=None if difference is None else Difference(**difference), **answer)


def trace(record: str | Path) -> list[dict[str, Any]]:
    """Read the trace of a record: its inputs and its effects with their causes, in order.

    Returns
    -------
    list of dict
        One for each line, with the keys of ``docs/reference/trace.md``: ``t``, ``kind``, ``task`` and
        more. ``pandas.DataFrame`` takes the list as it is.

    Raises
    ------
    MissionError
        The record cannot be read.

    Warns
    -----
    RecordWarning
        The record is incomplete, was changed, is not as it was signed, or is of another version of Apex.
    """
    # Texts of messages may hold other ends of lines, such as U+2028.
    return [json.loads(line) for line in _apex.trace_json(Path(record)).split("\n") if line]


def fork(
    record: str | Path,
    at_s: float,
    *,
    output: str | Path,
    wind_factor: float | None = None,
    seed: int | None = None,
    inputs: Iterable[dict[str, Any]] | None = None,
    plan: Sequence[str] | None = None,
    until_s: float | None = None,
    planners: Iterable[Planner] = (),
) -> tuple[Report, Report]:
    """Continue a recorded flight from an instant on, with changes, and record the whole flight.

    Ctrl-C stops the flight; the record is closed before the exception is raised.

    Parameters
    ----------
    record : str or Path
        A record that `fly` or ``apex fly`` has written.
    at_s : float
        The instant, in seconds of mission time.
    output : str or Path
        The flight record to write.
    wind_factor : float, optional
        Strength of the wind after the instant relative to the mission's, from 0 to 100.
    seed : int, optional
        Seed of turbulence and radio links after the instant.
    inputs : iterable of dict, optional
        Inputs after the instant: ``{"t": SECONDS, "event": "(FORM)"}``, or ``{"t": SECONDS, "measurement":
        "(ATTRIBUTE OBJECT)", "value": VALUE}``.
    plan : sequence of str, optional
        Targets to visit in this order instead of planning.
    until_s : float, optional
        Mission time at which the forked flight ends at the latest.
    planners : iterable of Planner
        User-defined planners in addition to the planners that ship with Apex.

    Returns
    -------
    recorded, forked : Report
        The report of the recorded flight, computed from its record, and that of the forked flight.

    Raises
    ------
    MissionError
        The record cannot be forked at this instant, or the flight fails.
    InputError
        A number is out of range, or the name of a planner is invalid or taken.

    Warns
    -----
    RecordWarning
        The record is incomplete, was changed, is not as it was signed, or is of another version of Apex.
    """
    lines = None if inputs is None else "".join(f"{json.dumps(line)}\n" for line in inputs)
    changes = (wind_factor, seed_of(seed), lines, list(plan or ()))
    answer = json.loads(_apex.fork_json(Path(record), at_s, changes, (Path(output), until_s), means(planners)))
    return Report(**answer["recorded"]), Report(**answer["forked"])


def report(record: str | Path) -> Report:
    """Compute the report of a recorded flight from its steps.

    Raises
    ------
    MissionError
        The record cannot be read, or is not the record of a mission.

    Warns
    -----
    RecordWarning
        The record is incomplete, was changed, is not as it was signed, or is of another version of Apex.
    """
    return Report(**json.loads(_apex.report_json(Path(record))))
