"""User-defined costs: any plan is scored by them, and planners plan with their tables."""

import json
import math

import numpy as np
import pytest

from apex_autonomy import InputError, PlanningError, cost_table, expected_cost, plan, problem

HORIZON_S = 3600.0
ALARM_S = 30.0
GIVEN = "small-fixed-uniform-6-globular@2"


def smoke(age_s: float) -> float:
    """Return 0 until an alarm, then 0.2 for the alarm plus a share of the building that has burnt."""
    return 0.0 if age_s < ALARM_S else 0.2 + 1.0 - math.exp(-(((age_s - ALARM_S) / 900.0) ** 2))


def test_a_plan_is_scored_as_the_planner_scored_it():
    given = problem(GIVEN)
    answer = plan(given, budget_s=0.02)
    content = answer["plan"]["Surveillance"]
    for visits in (answer, answer["plan"], content, content["visits"], reversed(content["visits"])):
        score = expected_cost(given, visits)
        assert score.total == pytest.approx(answer["value"], rel=1e-12)
        assert sum(target.expected_cost for target in score.targets.values()) == pytest.approx(score.total)
    assert list(score.targets) == [target["name"] for target in given["Surveillance"]["targets"]]
    never = expected_cost(json.dumps(given), [])
    assert {(target.observations, target.longest_gap_s) for target in never.targets.values()} == {(0, HORIZON_S)}
    assert never.total > score.total


def test_a_family_written_in_python_costs_the_same():
    given = problem(GIVEN)
    visits = plan(given, budget_s=0.02)
    costs = {}
    for target in given["Surveillance"]["targets"]:
        family = target["cost"]["Saturating"]
        costs[target["name"]] = lambda age_s, m=family["maximum"], r=family["rate_per_s"]: -m * math.expm1(-r * age_s)
    assert expected_cost(given, visits, costs=costs).total == pytest.approx(visits["value"], rel=1e-9)
    for target in given["Surveillance"]["targets"]:
        target["rate"]["steps"] = [[0.0, 1e-4], [900.0, 5e-3]]
    often = expected_cost(given, visits).total
    first = expected_cost(given, visits, survival=True).total
    assert 0.1 * often < first < 0.99 * often
    assert expected_cost(given, visits, costs=costs, survival=True).total == pytest.approx(first, rel=1e-9)


def test_jumps_may_be_named_and_save_calls():
    given = problem(GIVEN)
    name = given["Surveillance"]["targets"][0]["name"]
    calls = []

    def counted(age_s):
        calls.append(age_s)
        return smoke(age_s)

    found = expected_cost(given, [], costs={name: counted}).targets[name].expected_cost
    searching, calls[:] = len(calls), []
    named = expected_cost(given, [], costs={name: (counted, [ALARM_S])}).targets[name].expected_cost
    assert named == pytest.approx(found, rel=1e-9) and len(calls) < searching / 3


@pytest.mark.parametrize("relative_error", [1e-2, 1e-4])
def test_a_cost_is_tabulated_planned_and_scored(relative_error):
    given = problem(GIVEN)
    table = cost_table(smoke, horizon_s=HORIZON_S, relative_error=relative_error)
    for target in given["Surveillance"]["targets"]:
        target["cost"] = table
    answer = plan(given, budget_s=0.05)
    names = [target["name"] for target in given["Surveillance"]["targets"]]
    exact = expected_cost(given, answer, costs=dict.fromkeys(names, smoke))
    # Where a cost is below a thousandth of the cost of the oldest age, the error is relative to that thousandth.
    rates = [target["rate"]["steps"][0][1] for target in given["Surveillance"]["targets"]]
    small = sum(rates) * HORIZON_S * smoke(HORIZON_S) / 1000
    assert abs(answer["value"] - exact.total) <= relative_error * (exact.total + small)
    assert answer["value"] != exact.total
    assert 0 < answer["bound"] <= answer["value"] < expected_cost(given, []).total


def test_the_table_is_near_at_every_age():
    points = np.array(cost_table(smoke, horizon_s=HORIZON_S, relative_error=1e-3)["Table"]["points"])
    assert points[0, 0] == 0 and points[-1, 0] == HORIZON_S and len(points) < 200
    ages = np.linspace(0, HORIZON_S, 10_001)[1:]
    ages = ages[np.abs(ages - ALARM_S) > 1e-6]
    exact = np.array([smoke(age_s) for age_s in ages])
    off = np.abs(np.interp(ages, points[:, 0], points[:, 1]) - exact)
    assert (off <= 1e-3 * np.maximum(exact, smoke(HORIZON_S) / 1000)).all()


def raises(age_s):
    raise ZeroDivisionError("no idea")


@pytest.mark.parametrize(
    ("cost", "words"),
    [
        (raises, r"s old cannot be computed: ZeroDivisionError: no idea"),
        (lambda age_s: "much", r"s old cannot be computed: TypeError: .*"),
        (lambda age_s: None, r"s old cannot be computed: TypeError: .*"),
        (lambda age_s: -1, r"s old is -1; a cost is finite and not negative"),
        (lambda age_s: math.nan, r"s old is NaN; a cost is finite"),
        (lambda age_s: 1e4 - age_s, r"falls from .* s to .* s; cost never falls with age"),
    ],
)
def test_what_is_no_cost_is_told_with_target_and_age(cost, words):
    given = problem(GIVEN)
    name = given["Surveillance"]["targets"][1]["name"]
    with pytest.raises(InputError, match=f"{name}: the cost of an event .*{words}") as caught:
        expected_cost(given, [], costs={name: cost})
    assert isinstance(caught.value.__cause__, ZeroDivisionError) == (cost is raises)
    with pytest.raises(InputError, match=f"the cost of an event .*{words}"):
        cost_table(cost, horizon_s=100)


def test_an_interrupt_stays_one():
    def interrupted(age_s):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cost_table(interrupted, horizon_s=100)


def test_mistakes_are_told():
    given = problem(GIVEN)
    name = given["Surveillance"]["targets"][0]["name"]
    with pytest.raises(InputError, match="atlantis is not a target of the problem"):
        expected_cost(given, [{"target": "atlantis", "end_s": 1}])
    with pytest.raises(InputError, match="atlantis is not a target of the problem"):
        expected_cost(given, [], costs={"atlantis": smoke})
    with pytest.raises(InputError, match="no `target` and `end_s`"):
        expected_cost(given, [{"target": name}])
    with pytest.raises(InputError, match="ends at NaN"):
        expected_cost(given, [{"target": name, "end_s": math.nan}])
    with pytest.raises(InputError, match="neither a plan of surveillance nor"):
        expected_cost(given, {"SingleVisit": {}})
    with pytest.raises(InputError, match=f"the cost of {name} is 7, which cannot be called"):
        expected_cost(given, [], costs={name: 7})
    with pytest.raises(PlanningError, match=r"the problem:1:.*not a planning problem"):
        expected_cost({"Surveillance": 7}, [])
    with pytest.raises(InputError, match="oldest age is 0 s"):
        cost_table(smoke, horizon_s=0)
    with pytest.raises(InputError, match="relative error is 2"):
        cost_table(smoke, horizon_s=1, relative_error=2)
    with pytest.raises(InputError, match="points and may have 1000"):
        cost_table(lambda age_s: math.floor(age_s), horizon_s=3600)
