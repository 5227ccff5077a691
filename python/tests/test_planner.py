"""Planners of third parties, in Python: the example of the guide, and planners that misbehave."""

import importlib.util
import itertools
import json
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

from apex_autonomy import InputError, Planner, PlanningError, apex, plan

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "python/examples/swaps.py"
MISSION = ROOT / "missions/structure-watch"
FORM = "(solver auto (index (patrol the structures)) :budget 500ms)"
PATROL = "(step patrol (patrol the structures) (waitfor (end ?up))"


def example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("swaps", EXAMPLE)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def mission(folder: Path, solver: str, budget: str) -> Path:
    """Copy the mission so that it asks `solver`, and goes on without a plan."""
    folder.mkdir()
    for file in MISSION.iterdir():
        text = file.read_text()
        text = text.replace(FORM, f"(solver {solver} (index (patrol the structures)) :budget {budget})")
        (folder / file.name).write_text(text.replace(PATROL, f"{PATROL} (on-failure (inform (without-a-plan)))"))
    return folder


def problem(capfd: pytest.CaptureFixture[str], name: str = "small-fixed-uniform-6-globular@2") -> dict:
    assert apex("plan", name, "--problem")
    return json.loads(capfd.readouterr().out)


def test_the_example_is_short_and_on_the_page():
    code = EXAMPLE.read_text()
    assert code.count("\n") < 60
    assert f"```python\n{code}```\n" in (ROOT / "docs/guides/adding-a-solver.md").read_text()


def test_the_example_is_measured_and_chosen_by_its_table(tmp_path, capfd):
    profile, table = str(tmp_path / "mine.txt"), str(tmp_path / "mine.csv")
    swaps = [example().Swaps()]
    cell = "small-fixed-fixed-4-uniform"
    build = ["--cells", cell, "--missions", "3", "--budgets", "1ms", "--planners", "py-swaps", "--no-progress"]
    assert apex("profile", "build", profile, *build, planners=swaps)
    update = ["--planners", "nearest-neighbour,py-swaps", "--no-progress"]
    assert apex("profile", "update", profile, *update, planners=swaps)
    assert apex("profile", "build", profile, *build, "--table", table, planners=swaps)
    capfd.readouterr()
    assert apex("plan", f"{cell}@9", "--table", table, "--budget", "1ms", planners=swaps)
    assert "planned by py-swaps" in capfd.readouterr().out


def test_the_example_plans(capfd):
    swaps = example().Swaps()
    given = problem(capfd)
    answer = plan(given, planner=swaps, budget_s=0.01, seed=3)
    visits = answer["plan"]["Surveillance"]["visits"]
    assert answer["plan"]["Surveillance"]["solver"] == "py-swaps"
    assert len({visit["target"] for visit in visits}) == 6
    assert 0 < answer["bound"] <= answer["value"]
    assert plan(given, planner=swaps, budget_s=0.01, seed=3)["plan"] == answer["plan"]
    # The planner that ships is better, and asked by name.
    assert plan(json.dumps(given), planner="anytime", budget_s=0.1)["value"] <= answer["value"]


def test_the_example_flies(capfd, tmp_path):
    folder, record = mission(tmp_path / "m", "py-swaps", "5ms"), str(tmp_path / "flown.apex")
    assert apex("fly", str(folder), "--record", record, "--no-progress", planners=[example().Swaps()])
    assert apex("trace", record, "--type", "plan")
    assert "because py-swaps answered request 0" in capfd.readouterr().out
    assert apex("replay", record)


def test_the_example_is_a_program():
    command = [sys.executable, str(EXAMPLE), "plan", str(MISSION), "--solver", "py-swaps", "--budget", "5ms"]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "planned by py-swaps" in said


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
        ("loops", "the solver loops gave no answer within 0.5 s and was given up"),
        ("overruns", "the solver overruns went on after its 1000 units of work"),
        ("hoards", "the solver hoards took more than 64 MiB of memory"),
        ("dreams", "it visits atlantis, which is no target"),
        ("babbles", "answered with what is no plan"),
        ("counts", "answered with what is no plan"),
        ("other", "not JSON serializable"),
        ("lies", "the plan of `lies` breaks"),
    ],
)
def test_misconduct_is_named_in_the_record_and_the_flight_goes_on(capfd, tmp_path, name, named):
    folder, record = mission(tmp_path / "m", name, "1ms"), str(tmp_path / "flown.apex")
    limits = ["--solver-patience", "0.5s" if name == "loops" else "60s"]
    limits += ["--solver-memory", "64" if name == "hoards" else "100000"]
    arguments = ["fly", str(folder), "--record", record, "--no-progress", "--until", "2min", *limits]
    assert apex(*arguments, planners=[Bad(name)])
    capfd.readouterr()
    assert apex("trace", record)
    trace = capfd.readouterr().out
    assert named in trace and "(without-a-plan)" in trace
    assert apex("trace", record, "--from", "1:50")
    assert "signal-level" in capfd.readouterr().out


def test_a_planner_that_loops_is_truly_stopped(tmp_path, capfd):
    steps = []

    class Counts(Planner):
        name = "counts"

        def plan(self, problem, environment):
            while True:
                steps.append(1)

    folder = mission(tmp_path / "m", "counts", "1ms")
    more = ["--record", str(tmp_path / "r.apex"), "--no-progress", "--until", "40s", "--solver-patience", "0.2s"]
    assert apex("fly", str(folder), *more, planners=[Counts()])
    capfd.readouterr()
    for _ in range(100):
        before = len(steps)
        time.sleep(0.05)
        if len(steps) == before:
            return
    pytest.fail("it goes on counting")


def test_mistakes_are_told(capfd):
    given = problem(capfd)
    with pytest.raises(PlanningError, match="there is no solver `magic`"):
        plan(given, planner="magic")
    with pytest.raises(PlanningError, match=r"the problem:1:.*no planning problem"):
        plan({"Surveillance": {"targets": 7}})
    given["Surveillance"]["horizon_s"] = -1
    with pytest.raises(PlanningError, match="The horizon is -1"):
        plan(given)
    with pytest.raises(InputError, match="called `wam` already"):
        apex("plan", "x", planners=[Bad("wam")])
    with pytest.raises(InputError, match="unrecognized subcommand"):
        apex("fyl")
