"""The profile of planners, one task a cell: on the processes of this machine, or with --ray on a Ray cluster.

Missions are independent and planners deterministic, so the file is the same, byte for byte, for any number of
processes and machines. Every machine needs the package `apex_autonomy`. What this does not know goes to
`apex profile build`: `--missions`, `--budgets`, `--planners`.
"""

import argparse
import functools
import multiprocessing
import pathlib
import sys
import tempfile

from apex_autonomy import apex


def measured(cells: str, *, options: tuple[str, ...]) -> str:
    """Measure all planners in cells, and return the profile's text."""
    with tempfile.TemporaryDirectory() as folder:
        part = pathlib.Path(folder) / "part.txt"
        if not apex("profile", "build", str(part), "--cells", cells, "--threads", "1", "--no-progress", *options):
            raise RuntimeError(f"{cells} cannot be measured")
        return part.read_text()


def cells(which: str) -> list[str]:
    """Return the names of the cells: of `all`, of `subset`, or those with commas between."""
    if which not in ("all", "subset"):
        return which.split(",")
    # The quickest profile there is names them.
    names = measured(which, options=("--missions", "1", "--budgets", "1ms", "--planners", "nearest-neighbour"))
    return [line.split()[1] for line in names.splitlines() if line.startswith("cell ")]


def main(arguments: list[str]) -> int:
    """Measure all cells and merge the parts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("profile", help="the profile to write")
    parser.add_argument("--cells", default="subset", help="all, subset, or names with commas between")
    parser.add_argument(
        "--ray", action="store_true", help="tasks go to the Ray cluster that is connected, or a local one"
    )
    parser.add_argument("--processes", type=int, help="at a time; all cores unless told otherwise")
    known, options = parser.parse_known_args(arguments)
    if known.ray:
        from ray.util.multiprocessing import Pool
    else:
        Pool = multiprocessing.get_context("spawn").Pool
    task = functools.partial(measured, options=tuple(options))
    with Pool(known.processes) as pool:
        parts = pool.map(task, cells(known.cells), chunksize=1)
    with tempfile.TemporaryDirectory() as folder:
        files = [pathlib.Path(folder) / f"part-{number}.txt" for number in range(len(parts))]
        for file, part in zip(files, parts, strict=True):
            file.write_text(part)
        return 0 if apex("profile", "merge", known.profile, *map(str, files)) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
