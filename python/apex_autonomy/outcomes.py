"""Plans, flights, reports and replays, as :mod:`apex_autonomy.flight` returns them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

__all__ = ["Difference", "Flight", "Plan", "ReplayResult", "Report", "Target"]


@dataclass(frozen=True)
class Target:
    """A target or named place of a mission.

    Attributes
    ----------
    id, name : str
        Name in plans and in reports.
    kind : str
        ``"fire"``, ``"site"``, ``"base"`` or ``"place"``.
    latitude_deg, longitude_deg, elevation_m : float
        Position, and elevation above mean sea level.
    worth : float
        Value of a fire in points, or greatest cost of an event at a site; 0 for bases and places.
    """

    id: str
    name: str
    kind: str
    latitude_deg: float
    longitude_deg: float
    elevation_m: float
    worth: float


@dataclass(frozen=True)
class Plan:
    """A plan for a mission.

    Attributes
    ----------
    problem : dict
        The problem that the mission poses (``docs/reference/planning-problems.md``).
    answer : dict
        The output of ``apex plan --json``: ``value``, ``bound``, ``plan`` and more.
    """

    problem: dict[str, Any]
    answer: dict[str, Any]


@dataclass(frozen=True)
class Report:
    """Results of a flight.

    Attributes
    ----------
    sections : dict
        The report by section, in the format of ``apex fly --json``.
    text : str
        The report as text.
    """

    sections: dict[str, Any]
    text: str


@dataclass(frozen=True)
class Flight:
    """A flight that has ended.

    Attributes
    ----------
    end_s : float
        Mission time at the end.
    reason : str
        Reason of the end.
    report : dict
        Its results, by section.
    text : str
        The report as text.
    record : Path
        The flight record.
    steps, events, effects : int
        Steps of the executive, events that came in, decisions and other effects.
    """

    end_s: float
    reason: str
    report: dict[str, Any]
    text: str
    record: Path
    steps: int
    events: int
    effects: int


@dataclass(frozen=True)
class Difference:
    """The first difference between a record and its replay.

    Attributes
    ----------
    t_s : float
        Mission time.
    step : int
        Number of the step in the record.
    what : str
        The effect, planning problem or situation that differs.
    recorded, replayed : str or None
        The values of both flights; None if a flight has none.
    """

    t_s: float
    step: int
    what: str
    recorded: str | None
    replayed: str | None


@dataclass(frozen=True)
class ReplayResult:
    """Result of a replay.

    Attributes
    ----------
    steps, effects, problems : int
        Steps executed again, effects compared, planning problems posed again and compared.
    end_s : float
        The last instant that was executed.
    difference : Difference or None
        The first difference; None if the record is confirmed.
    """

    steps: int
    effects: int
    problems: int
    end_s: float
    difference: Difference | None

    @property
    def equal(self) -> bool:
        """True if every decision and every planning problem is as recorded."""
        return self.difference is None
