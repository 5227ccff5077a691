"""Missions that Python plans, flies, replays and forks."""

import os
import signal
import sqlite3
import threading
import time
import warnings
from pathlib import Path

import pytest

from apex_autonomy import (
    InputError,
    Mission,
    MissionError,
    Planner,
    PlanningError,
    RecordWarning,
    fly,
    fork,
    replay,
    report,
    trace,
)

WATCH = Path(__file__).parents[2] / "crates/cli/tests/missions/plain-watch"
SHORT_S = 1200


class Rounds(Planner):
    """Visits all targets in the order of the problem."""

    name = "rounds"

    def plan(self, problem, environment):
        """Return three rounds."""
        return [target["name"] for target in problem["targets"]] * 3


@pytest.fixture(autouse=True)
def interrupts():
    """Hear interrupts: Python ignores them in a job that a shell starts in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def altered(folder: Path, before: str, after: str) -> Path:
    """Copy the mission with a change of its program."""
    folder.mkdir()
    for file in WATCH.iterdir():
        text = file.read_text()
        if file.name == "mission.pdl":
            assert before in text
            text = text.replace(before, after)
        (folder / file.name).write_text(text)
    return folder


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Fly a part of the mission with a short time for planning."""
    folder = tmp_path_factory.mktemp("flown")
    mission = Mission.load(altered(folder / "m", ":budget 500ms", ":budget 5ms"))
    return mission, fly(mission, record=folder / "flight.apex", until_s=SHORT_S)


def test_a_mission_says_what_it_is_and_plans():
    mission = Mission.load(WATCH)
    assert (mission.name, mission.duration_s, mission.warnings) == ("Structure Watch", 3600.0, [])
    sites = [target.id for target in mission.targets if target.kind == "site"]
    planned = mission.plan(planner="nearest-neighbour", budget_s=0.01)
    assert [target["name"] for target in planned.problem["Surveillance"]["targets"]] == sites
    assert {visit["target"] for visit in planned.answer["plan"]["Surveillance"]["visits"]} <= set(sites)
    with pytest.raises(PlanningError, match="there is no solver `magic`") as caught:
        mission.plan(planner="magic")
    assert caught.value.message == "no plan was found" and "magic" in caught.value.reason


def test_the_same_flight_twice_has_the_same_report(flown, tmp_path):
    mission, flight = flown
    assert flight.end_s == SHORT_S and flight.report and "Structure Watch" in flight.text
    for _ in range(2):
        # The second time it replaces the record of the first.
        again = fly(mission, record=tmp_path / "again.apex", until_s=SHORT_S)
        assert (again.report, again.text, again.effects) == (flight.report, flight.text, flight.effects)
    other = fly(mission, record=tmp_path / "other.apex", until_s=SHORT_S - 300)
    assert other.report != flight.report


def test_a_record_is_replayed_and_reported(flown):
    _, flight = flown
    replayed = replay(flight.record)
    assert replayed.equal and replayed.difference is None
    assert (replayed.steps, replayed.effects) == (flight.steps, flight.effects)
    assert replayed.problems >= 1
    assert report(flight.record).sections == flight.report
    assert report(flight.record).text == flight.text


def test_a_fork_without_change_equals_the_flight_and_one_with_another_plan_does_not(flown, tmp_path):
    _, flight = flown
    recorded, forked = fork(flight.record, 600, output=tmp_path / "same.apex", until_s=SHORT_S)
    assert recorded.sections == flight.report and forked.sections == flight.report
    order = [target.id for target in flown[0].targets if target.kind == "site"][:2]
    recorded, forked = fork(flight.record, 600, plan=order, output=tmp_path / "other.apex", until_s=SHORT_S)
    assert recorded.sections == flight.report and forked.sections != flight.report
    assert replay(tmp_path / "other.apex").equal
    with pytest.raises(MissionError, match="an input at 0:05:00 is not after 0:10:00") as caught:
        early = [{"t": 300, "event": "(ready pilot)"}]
        fork(flight.record, 600, inputs=early, output=tmp_path / "no.apex")
    assert caught.value.help


def test_a_planner_in_python_flies_while_other_threads_run(tmp_path):
    mission = Mission.load(altered(tmp_path / "m", "(solver auto", "(solver rounds"))
    counted, over = [0], threading.Event()

    def count():
        while not over.wait(0.001):
            counted[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    told = []
    flight = fly(mission, record=tmp_path / "f.apex", until_s=900, planners=[Rounds()], on_progress=told.append)
    over.set()
    thread.join()
    assert counted[0] > 0
    assert told == sorted(told) and 10 <= len(told) <= 15
    assert flight.end_s == 900
    with sqlite3.connect(tmp_path / "f.apex") as connection:
        assert any('"solver":"rounds"' in plan for (plan,) in connection.execute("SELECT plan FROM answer"))
    assert replay(tmp_path / "f.apex").equal


def test_exceptions_and_signals_stop_a_flight_and_close_its_record(tmp_path):
    mission = Mission.load(WATCH)

    def refuse(now_s):
        if now_s >= 300:
            raise ValueError("enough")

    def interrupt(now_s):
        if now_s >= 300:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(ValueError, match="enough"):
        fly(mission, record=tmp_path / "refused.apex", on_progress=refuse)
    with pytest.raises(KeyboardInterrupt):
        fly(mission, record=tmp_path / "broken.apex", on_progress=interrupt)
    for record in ("refused.apex", "broken.apex"):
        assert "without the end" not in report(tmp_path / record).text
        assert 300 <= report(tmp_path / record).sections["end"]["t"] < 3600
        assert replay(tmp_path / record).equal


def test_a_signal_stops_a_fork_and_closes_its_record(flown, tmp_path):
    output = tmp_path / "broken.apex"

    def interrupt():
        while not output.exists():
            time.sleep(0.001)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        fork(flown[1].record, 600, seed=3, output=output)
    thread.join()
    assert "without the end" not in report(output).text
    assert report(output).sections["end"]["t"] < 3600


def test_failures_name_place_and_help(tmp_path):
    with pytest.raises(MissionError) as caught:
        Mission.load(tmp_path / "nowhere")
    assert "nowhere" in str(caught.value) and caught.value.help
    folder = altered(tmp_path / "typo", "(take off to 110m)", "(take off to 110m")
    with pytest.raises(MissionError, match="has errors") as caught:
        Mission.load(folder)
    assert "mission.pdl:" in caught.value.reason
    folder = altered(tmp_path / "data", "sites.geojson", "sights.geojson")
    with pytest.raises(MissionError, match=r"sights\.geojson") as caught:
        Mission.load(folder)
    assert caught.value.message and caught.value.help
    folder = altered(tmp_path / "outside", ":type native-sim", ":type foreign-sim")
    with pytest.raises(MissionError, match="an external simulator owns the clock") as caught:
        fly(Mission.load(folder), record=tmp_path / "no.apex")
    assert caught.value.place and not (tmp_path / "no.apex").exists()
    with pytest.raises(MissionError, match="there is no flight record"):
        replay(tmp_path / "no.apex")
    with pytest.raises(InputError, match="until_s"):
        fly(Mission.load(WATCH), record=tmp_path / "no.apex", until_s=0)


def test_a_trace_with_other_ends_of_lines_in_its_texts_is_read(flown, tmp_path):
    _, flight = flown
    said = "a\u2028b\u0085c"
    note = {"t": 610, "event": f'(note "{said}")'}
    fork(flight.record, 600, output=tmp_path / "noted.apex", inputs=[note], until_s=620)
    events = [line["form"] for line in trace(tmp_path / "noted.apex") if line["kind"] == "event"]
    assert f'(note "{said}")' in events


def test_a_changed_file_is_read_with_a_warning(flown, tmp_path):
    _, flight = flown
    copy = tmp_path / "packed.apex"
    copy.write_bytes(Path(flight.record).read_bytes())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert replay(copy).equal
    database = sqlite3.connect(copy)
    database.execute("pragma user_version = 7")
    database.close()
    for read in (replay, trace, report):
        with pytest.warns(RecordWarning, match="changed after it was closed"):
            read(copy)
