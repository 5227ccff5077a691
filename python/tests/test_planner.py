"""Planners of third parties, in Python: the example of the guide, and planners that misbehave."""

import importlib.util
import itertools
import json
import sqlite3
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

from apex_autonomy import InputError, Mission, Planner, PlanningError, Profile, fly, plan, problem, replay, trace

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "python/examples/swaps.py"
MISSION = ROOT / "crates/cli/tests/missions/plain-watch"
FORM = "(solver auto (index (patrol the structures)) :budget 500ms)"
PATROL = "(step patrol (patrol the structures) (waitfor (end ?up))"


def example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("swaps", EXAMPLE)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def mission(folder: Path, solver: str, budget: str) -> Path:
    """Copy the mission so that it asks `solver`, and continues without a plan."""
    folder.mkdir()
    for file in MISSION.iterdir():
        text = file.read_text()
        text = text.replace(FORM, f"(solver {solver} (index (patrol the structures)) :budget {budget})")
        # The way home from the farthest structure takes up to six minutes after the watch of 55 minutes.
        text = text.replace(":duration 1h", ":duration 65min")
        (folder / file.name).write_text(text.replace(PATROL, f"{PATROL} (on-failure (inform (without-a-plan)))"))
    return folder


def said(record: Path) -> str:
    """Return the words of the trace of a record."""
    return "\n".join(" ".join(map(str, line.values())) for line in trace(record))


def test_the_example_is_short_and_on_the_page():
    code = EXAMPLE.read_text()
    assert code.count("\n") < 60
    assert f"```python\n{code}```\n" in (ROOT / "docs/guides/adding-a-solver.md").read_text()


def test_the_example_is_measured_and_chosen_by_its_table():
    swaps = example().Swaps()
    cell = "small-fixed-fixed-4-uniform"
    mine = Profile.measure([cell], planners=[swaps], missions=3, budgets_s=[0.001])
    both = mine.with_planners(["nearest-neighbour", swaps])
    assert both.text != mine.text and len(both.text) > len(mine.text)
    answer = plan(problem(f"{cell}@9"), table=mine.table, budget_s=0.001, planners=[swaps])
    assert answer["plan"]["Surveillance"]["solver"] == "py-swaps"
    with pytest.raises(PlanningError, match="there is no solver `py-swaps`, which the profile table chooses"):
        plan(problem(f"{cell}@9"), table=mine.table, budget_s=0.001)


def test_the_example_plans():
    swaps = example().Swaps()
    given = problem("small-fixed-uniform-6-globular@2")
    answer = plan(given, planner=swaps, budget_s=0.01, seed=3)
    visits = answer["plan"]["Surveillance"]["visits"]
    assert answer["plan"]["Surveillance"]["solver"] == "py-swaps"
    assert len({visit["target"] for visit in visits}) == 6
    assert 0 < answer["bound"] <= answer["value"]
    assert plan(given, planner=swaps, budget_s=0.01, seed=3)["plan"] == answer["plan"]
    # A shipped planner, requested by its name, is at least as good.
    assert plan(json.dumps(given), planner="anytime", budget_s=0.1)["value"] <= answer["value"]


def test_the_example_flies(tmp_path):
    folder, record = mission(tmp_path / "m", "py-swaps", "5ms"), tmp_path / "flown.apex"
    flight = fly(Mission.load(folder), record=record, planners=[example().Swaps()])
    assert flight.reason == "the initial task is done"
    assert "new plan: 16 visits to 16 of 16 targets" in flight.text
    assert len(flight.report["left-out"]) <= 2
    assert "py-swaps" in said(record)
    assert replay(record).equal


def test_the_example_is_a_program():
    command = [sys.executable, str(EXAMPLE), str(MISSION)]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert printed.startswith("planned by py-swaps: ")


class Bad(Planner):
    """Misbehaves in the way of its name."""

    def __init__(self, name: str) -> None:
        self.name = name

    def plan(self, problem, environment):
        """Misbehave."""
        if self.name == "raises":
            raise ValueError("no idea left")
        if self.name == "loops":
            for _ in itertools.count():
                pass
        if self.name == "overruns":
            while True:
                environment.charge(1_000)
        if self.name == "hoards":
            hoard = []
            while len(hoard) < 2_000:
                hoard.append(bytearray(b"7" * (1 << 20)))
        answers = {"dreams": ["atlantis"], "babbles": {"Surveillance": 7}, "counts": 42, "other": object()}
        if self.name == "lies":
            empty = {"cycle": [], "visits": [], "return_s": None, "left_out": [], "summary": "", "solver": "lies"}
            return {"Surveillance": {**empty, "expected_cost": 0.0, "expected_cost_bound": None}}
        return answers[self.name]


@pytest.mark.parametrize(
    ("name", "named"),
    [
        ("raises", "ValueError: no idea left"),
        ("loops", "the solver loops gave no answer within 0.5 s and was abandoned"),
        ("overruns", "the solver overruns continued after its 1000 units of work"),
        ("hoards", "the solver hoards took more than 64 MiB of memory"),
        ("dreams", "it visits atlantis, which is not a target"),
        ("babbles", "answered without a valid plan"),
        ("counts", "answered without a valid plan"),
        ("other", "not JSON serializable"),
        ("lies", "the plan of `lies` breaks"),
    ],
)
def test_misconduct_is_named_in_the_record_and_the_flight_goes_on(tmp_path, name, named):
    folder, record = mission(tmp_path / "m", name, "1ms"), tmp_path / "flown.apex"
    timeout_s, memory_mib = 0.5 if name == "loops" else 60, 64 if name == "hoards" else 100_000
    limits = {"solver_timeout_s": timeout_s, "solver_memory_mib": memory_mib}
    flight = fly(Mission.load(folder), record=record, until_s=120, planners=[Bad(name)], **limits)
    assert flight.end_s == 120
    assert "(without-a-plan)" in said(record)
    with sqlite3.connect(record) as connection:
        answers = connection.execute("SELECT detail FROM answer").fetchall()
        told = "\n".join(str(detail) for (detail,) in answers)
    assert named in told or named in said(record)


def test_a_planner_that_loops_is_truly_stopped(tmp_path):
    steps = []

    class Counts(Planner):
        name = "counts"

        def plan(self, problem, environment):
            while True:
                steps.append(1)

    flown = Mission.load(mission(tmp_path / "m", "counts", "1ms"))
    fly(flown, record=tmp_path / "r.apex", until_s=40, solver_timeout_s=0.2, planners=[Counts()])
    for _ in range(100):
        before = len(steps)
        time.sleep(0.05)
        if len(steps) == before:
            return
    pytest.fail("it goes on counting")


def test_mistakes_are_told():
    given = problem("small-fixed-uniform-6-globular@2")
    with pytest.raises(PlanningError, match="there is no solver `magic`"):
        plan(given, planner="magic")
    with pytest.raises(PlanningError, match=r"the problem:1:.*not a planning problem"):
        plan({"Surveillance": {"targets": 7}})
    given["Surveillance"]["horizon_s"] = -1
    with pytest.raises(PlanningError, match="the horizon is -1"):
        plan(given)
    with pytest.raises(InputError, match="called `wam` already"):
        plan(given, planners=[Bad("wam")])
    with pytest.raises(PlanningError, match="there is no mission, file or test mission called atlantis") as caught:
        problem("atlantis")
    assert caught.value.help
