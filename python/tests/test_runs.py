"""Series of flights: rows in order, the same for any number of threads, bad numbers refused."""

from pathlib import Path

import pyarrow.csv
import pyarrow.parquet
import pytest

from apex_autonomy import InputError, Mission, MissionError, fly_runs

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


@pytest.mark.parametrize("end", ["parquet", "csv"])
def test_the_table_has_the_rows(tmp_path: Path, end: str) -> None:
    path = tmp_path / f"runs.{end}"
    series = fly_runs(Mission.load(MISSION), runs=3, seed=5, out=path)
    read = pyarrow.parquet.read_table if end == "parquet" else pyarrow.csv.read_csv
    rows = read(path).to_pylist()
    assert set(rows[0]) == set(series.rows[0])
    numbers = ["seed", "end_s", "score", "benefits", "observed", "left_out", "reflies", "plans", "positions"]
    assert [[row[name] for name in numbers] for row in rows] == [[row[name] for name in numbers] for row in series.rows]
    assert [row["outcome"] for row in rows] == ["completed"] * 3


def test_a_table_that_cannot_be_written_is_named_before_the_flights(tmp_path: Path) -> None:
    mission = Mission.load(MISSION)
    flown: list[int] = []
    with pytest.raises(MissionError, match="does not determine the format"):
        fly_runs(mission, runs=2, out=tmp_path / "runs.txt", on_progress=flown.append)
    with pytest.raises(MissionError, match="cannot write"):
        fly_runs(mission, runs=2, out=tmp_path / "absent" / "runs.csv", on_progress=flown.append)
    kept = tmp_path / "kept.csv"
    kept.write_text("of another series")
    with pytest.raises(MissionError, match="0 runs cannot be flown"):
        fly_runs(mission, runs=0, out=kept)
    assert kept.read_text() == "of another series"
    with pytest.raises(MissionError, match="0 runs cannot be flown"):
        fly_runs(mission, runs=0, out=tmp_path / "empty.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["kept.csv"]
    assert flown == []


def test_bad_numbers_and_exceptions_are_raised() -> None:
    mission = Mission.load(MISSION)
    with pytest.raises(MissionError, match="0 runs cannot be flown"):
        fly_runs(mission, runs=0)
    for wrong, words in [
        ({"runs": -1}, "`runs` is -1: write a whole number from 0"),
        ({"runs": 2.5}, "`runs` is 2.5"),
        ({"runs": 1, "jobs": -3}, "`jobs` is -3"),
        ({"runs": 1, "seed": -1}, "`seed` is -1: write a whole number from 0 to 18446744073709551615"),
        ({"runs": 1, "seed": True}, "`seed` is True"),
        ({"runs": 2, "seed": 2**64 - 1}, "the seed of the last of 2 runs"),
        ({"runs": 1, "solver_memory_mib": 0}, "`solver_memory_mib` is 0"),
        ({"runs": 1, "until_s": float("nan")}, "`until_s` is NaN: write a number greater than 0"),
        ({"runs": 1, "until_s": 1e300}, "`until_s` is 1e300"),
        ({"runs": 1, "solver_timeout_s": 0}, "`solver_timeout_s` is 0"),
        ({"runs": 1, "planners": [5]}, "5 is not a planner"),
    ]:
        with pytest.raises(InputError, match=words):
            fly_runs(mission, **wrong)

    def stop(_: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        fly_runs(mission, runs=50, on_progress=stop)
