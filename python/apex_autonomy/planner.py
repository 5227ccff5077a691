"""Planners written in Python: planning functions and flights use them like the planners that ship with Apex."""

from __future__ import annotations

import abc
import ctypes
import json
import os
import sys
import threading
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, TextIO

from apex_autonomy._apex import InputError, Means, PlannerContext, plan_json, problem_json
from apex_autonomy._arguments import SEED_MAX, whole

__all__ = ["Environment", "Planner", "plan", "problem"]

#: The largest limit of memory in MiB.
MEMORY_MIB_MAX = 2**32 - 1


class PlannerStopped(BaseException):
    """Raised in a planner that works on with an exhausted budget; not an ``Exception``, which many planners catch."""


class Environment:
    """The environment of a planner."""

    def __init__(self, surroundings: PlannerContext | _Program) -> None:
        self._surroundings = surroundings

    @property
    def seed(self) -> int:
        """Seed of the planner's random numbers: equal seed and budget give an equal plan."""
        return self._surroundings.seed

    @property
    def previous(self) -> dict[str, Any] | None:
        """The plan that is flown, or the best plan before the problem changed, to start from; None without one."""
        text = self._surroundings.previous_json
        return None if text is None else json.loads(text)

    @property
    def exhausted(self) -> bool:
        """True when the planner must return its best plan now."""
        return self._surroundings.exhausted

    @property
    def used(self) -> int:
        """Units charged so far."""
        return self._surroundings.used

    def charge(self, units: int) -> bool:
        """Charge `units` of work, each for a microsecond of flight; false when the planner must return now.

        The call waits while the planner is paused.
        """
        return self._surroundings.charge(units)

    def report(self, plan: Sequence[str] | dict[str, Any]) -> None:
        """Report a better plan than the previous one; the last report counts if the planner has to be stopped."""
        self._surroundings.report_json(json.dumps(plan))


class Planner(abc.ABC):
    """A user-defined planner.

    Attributes
    ----------
    name : str
        Its name in ``(solver NAME ..)`` and ``--solver NAME``: lower-case letters, digits, hyphens.
    kinds : sequence of str
        The problems it plans for: ``"Surveillance"``, ``"SingleVisit"``.
    """

    name: str
    kinds: Sequence[str] = ("Surveillance",)

    @abc.abstractmethod
    def plan(self, problem: dict[str, Any], environment: Environment) -> Sequence[str] | dict[str, Any]:
        """Plan for `problem`, the contents of its one member (``docs/reference/planning-problems.md``).

        Returns
        -------
        sequence of str, or dict
            For surveillance the names of the targets in the order of visits, repeated while time remains: Apex computes
            times and cost. For other problems, or instead, a plan as ``plan.schema.json`` describes it, with its kind.

        Raises
        ------
        Exception
            No plan was found; the text is the reason.
        """

    def serve(self) -> None:
        """Answer one problem on standard input, as a solver program (``docs/reference/solver-programs.md``).

        Output printed by the planner goes to standard error. When standard input ends, so does the process.
        """
        with os.fdopen(os.dup(1), "w", encoding="utf-8") as output:
            os.dup2(2, 1)
            request = json.loads(sys.stdin.readline())
            program = _Program(request, output)
            threading.Thread(target=program.listen, daemon=True).start()
            [contents] = request["problem"].values()
            try:
                answer = {"plan": self.plan(contents, Environment(program))}
            except Exception as error:
                answer = {"failed": str(error) or type(error).__name__}
            program.say(answer)


class _Program:
    """The context of a planner that runs in a separate process, with the methods of `PlannerContext`."""

    STEP = 10_000

    def __init__(self, request: dict[str, Any], output: TextIO) -> None:
        previous = request["previous"]
        self.seed: int = request["seed"]
        self.previous_json = None if previous is None else json.dumps(previous)
        self.used = 0
        self._allowed: int = request["work_units"]
        self._told = 0
        self._stopped = threading.Event()
        self._output = output

    @property
    def exhausted(self) -> bool:
        return self._stopped.is_set() or self.used >= self._allowed

    def charge(self, units: int) -> bool:
        self.used += units
        if self.used - self._told >= self.STEP:
            self._tell()
        return not self.exhausted

    def report_json(self, plan: str) -> None:
        self._tell()
        self._write(f'{{"report": {plan}}}')

    def say(self, answer: dict[str, Any]) -> None:
        self._tell()
        self._write(json.dumps(answer))

    def listen(self) -> None:
        if sys.stdin.readline():
            self._stopped.set()
            sys.stdin.read()
        os._exit(0)

    def _tell(self) -> None:
        units, self._told = self.used - self._told, self.used
        if units:
            self._write(json.dumps({"charge": units}))

    def _write(self, line: str) -> None:
        self._output.write(line + "\n")
        self._output.flush()


def _interrupt(identity: int) -> None:
    """Raise `PlannerStopped` in the thread with this identity, at its next bytecode instruction."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(identity), ctypes.py_object(PlannerStopped))


def _registered(planners: Iterable[Planner]) -> list[Any]:
    def call(planner: Planner) -> Callable[[str, PlannerContext], str]:
        def planned(problem: str, surroundings: PlannerContext) -> str:
            [contents] = json.loads(problem).values()
            return json.dumps(planner.plan(contents, Environment(surroundings)))

        return planned

    registered = []
    for planner in planners:
        if not isinstance(planner, Planner):
            raise InputError(f"{planner!r} is not a planner: write an object of a class derived from Planner")
        registered.append((planner.name, list(planner.kinds), call(planner), _interrupt))
    return registered


def means(
    planners: Iterable[Planner],
    *,
    table: str | None = None,
    solver_timeout_s: float | None = None,
    solver_memory_mib: int | None = None,
) -> Means:
    """Return the user-defined planners, the profile table and the limits of one request."""
    registered = _registered(planners)
    memory_mib = None if solver_memory_mib is None else whole("solver_memory_mib", solver_memory_mib, 1, MEMORY_MIB_MAX)
    return Means(registered, table=table, solver_timeout_s=solver_timeout_s, solver_memory_mib=memory_mib)


def chosen(planner: Planner | str | None, planners: Iterable[Planner]) -> tuple[str | None, list[Planner]]:
    """Return the name of the requested planner, and all planners to register."""
    if isinstance(planner, Planner):
        return planner.name, [*(other for other in planners if other is not planner), planner]
    return planner, list(planners)


def problem(name: str | Path) -> dict[str, Any]:
    """Read a planning problem.

    Parameters
    ----------
    name : str or Path
        The name of a test mission (``docs/reference/test-missions.md``), a problem's file, or a benchmark's file.

    Returns
    -------
    dict
        The problem as ``docs/reference/planning-problems.md`` describes it.

    Raises
    ------
    PlanningError
        The problem does not exist, or the file has other contents.

    Examples
    --------
    >>> from apex_autonomy import problem
    >>> len(problem("small-fixed-fixed-4-uniform@7")["Surveillance"]["targets"])
    4
    """
    read: dict[str, Any] = json.loads(problem_json(Path(name)))
    return read


def plan(
    problem: dict[str, Any] | str,
    *,
    planner: Planner | str | None = None,
    budget_s: float = 1.0,
    seed: int = 1,
    planners: Iterable[Planner] = (),
    table: str | None = None,
) -> dict[str, Any]:
    """Plan for a problem, check the plan and prove a bound.

    Parameters
    ----------
    problem : dict or str
        A problem as ``docs/reference/planning-problems.md`` describes it, or its JSON text.
    planner : Planner or str, optional
        A user-defined planner, or the name of a planner; by default the profile table selects one.
    budget_s : float
        Time for deliberation, in the time of a flight.
    seed : int
        Seed of the planner's random numbers.
    planners : iterable of Planner
        User-defined planners that `planner` or `table` may name.
    table : str, optional
        Text of the profile table (`Profile.table`); by default the one that ships with Apex.

    Returns
    -------
    dict
        The output of ``apex plan --json``: ``value``, ``bound``, ``plan`` and more.

    Raises
    ------
    PlanningError
        There is no plan; the message states the reason.
    InputError
        A number is out of range, or the name of a planner is invalid or taken.

    Examples
    --------
    >>> from apex_autonomy import plan, problem
    >>> answer = plan(problem("small-fixed-fixed-4-uniform"), planner="nearest-neighbour", budget_s=0.001)
    >>> answer["bound"] <= answer["value"]
    True
    """
    text = problem if isinstance(problem, str) else json.dumps(problem)
    name, own = chosen(planner, planners)
    answer: dict[str, Any] = json.loads(
        plan_json(text, name, budget_s, whole("seed", seed, 0, SEED_MAX), means(own, table=table))
    )
    return answer
