"""A planner in Python as a solver program: lines of JSON over standard input and output."""

import json
import subprocess
import sys

PROGRAM = """
from apex_autonomy import Planner

class Round(Planner):
    name = "round"

    def plan(self, problem, environment):
        print("thinking")
        names = [target["name"] for target in problem["targets"]]
        if not names:
            raise ValueError("there is nothing to visit")
        environment.report(names)
        while environment.charge(3_000):
            pass
        return [*names, str(environment.seed)]

Round().serve()
"""


def answer(targets: list[str]) -> tuple[list[dict[str, object]], str]:
    """Ask the program about these targets: its lines, and what it printed."""
    request = {
        "apex_solver": 1,
        "solver": "round",
        "seed": 7,
        "work_units": 25_000,
        "problem": {"Surveillance": {"targets": [{"name": name} for name in targets]}},
        "previous": None,
    }
    command = [sys.executable, "-c", PROGRAM]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as program:
        assert program.stdin and program.stdout and program.stderr
        program.stdin.write(json.dumps(request) + "\n")
        program.stdin.flush()
        # Standard input stays open: its end would end the program.
        lines = [json.loads(line) for line in program.stdout]
        return lines, program.stderr.read()


def test_a_planner_serves_the_protocol() -> None:
    lines, printed = answer(["barn", "winery"])
    assert lines[0] == {"report": ["barn", "winery"]}
    assert sum(line.get("charge", 0) for line in lines) == 27_000
    assert lines[-1] == {"plan": ["barn", "winery", "7"]}
    assert printed == "thinking\n"


def test_an_exception_says_why_there_is_no_plan() -> None:
    assert answer([])[0] == [{"failed": "there is nothing to visit"}]
