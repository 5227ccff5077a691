"""Series of flights: rows in order, the same for any number of threads, bad numbers refused."""

from pathlib import Path

import pytest

from apex_autonomy import Mission, MissionError, fly_runs

MISSION = Path(__file__).parents[2] / "missions" / "first-picture"


def test_rows_do_not_depend_on_jobs() -> None:
    mission = Mission.load(MISSION)
    told: list[int] = []
    alone = fly_runs(mission, runs=3, seed=5, on_progress=told.append)
    assert told == [1, 2, 3]
    assert [row["seed"] for row in alone.rows] == [5, 6, 7]
    assert fly_runs(mission, runs=3, seed=5, jobs=2).rows == alone.rows
    assert alone.summary["completed"] == 3
    assert alone.text.startswith("3 flights, 3 completed")


def test_bad_numbers_and_exceptions_are_raised() -> None:
    mission = Mission.load(MISSION)
    with pytest.raises(MissionError, match="0 runs cannot be flown"):
        fly_runs(mission, runs=0)

    def stop(_: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        fly_runs(mission, runs=50, on_progress=stop)
