"""The example that measures a profile in parts."""

import subprocess
import sys
from pathlib import Path

from apex_autonomy import Profile

EXAMPLE = Path(__file__).parents[2] / "python/examples/profile_in_parts.py"
CELLS = ["small-clustered-clustered-8-two-cluster", "large-fixed-fixed-4-uniform"]
OPTIONS = ["--missions", "2", "--budgets-ms", "1,3", "--planners", "two-opt,wam"]


def test_two_processes_measure_what_one_machine_measures(tmp_path: Path) -> None:
    parts = tmp_path / "parts.txt"
    command = [sys.executable, str(EXAMPLE), str(parts), "--cells", ",".join(CELLS), "--processes", "2", *OPTIONS]
    subprocess.run(command, check=True, timeout=300)
    whole = Profile.measure(reversed(CELLS), planners=["two-opt", "wam"], missions=2, budgets_s=[0.001, 0.003])
    assert parts.read_text() == whole.text


def test_what_cannot_be_measured_is_told(tmp_path: Path) -> None:
    command = [sys.executable, str(EXAMPLE), str(tmp_path / "no.txt"), "--cells", "huge-fixed-fixed-4-uniform"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode != 0 and "there is no cell huge-fixed-fixed-4-uniform" in done.stderr
    assert not (tmp_path / "no.txt").exists()
