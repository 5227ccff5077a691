"""The profile of planners, one task per cell: on the processes of this machine, or with --ray on a Ray cluster.

Missions are independent and planners deterministic, so the file is the same, byte for byte, for any number of
processes and machines. Every machine needs the package `apex_autonomy`.
"""

import argparse
import functools
import multiprocessing
import pathlib
import sys

from apex_autonomy import MissionError, Profile, profile_cells

SHIPPED = "nearest-neighbour,two-opt,wam,anytime"


def measured(cell: str, *, planners: list[str], missions: int, budgets_s: list[float]) -> str:
    """Measure planners in one cell, and return the profile's text."""
    return Profile.measure([cell], planners=planners, missions=missions, budgets_s=budgets_s).text


def main(arguments: list[str]) -> int:
    """Measure all cells and merge the parts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("profile", help="the profile to write")
    parser.add_argument("--cells", default="subset", help="all, subset, or names separated by commas")
    parser.add_argument("--missions", type=int, default=50, help="test missions of each cell")
    parser.add_argument("--budgets-ms", default="1,10,100,1000", help="times for deliberation, separated by commas")
    parser.add_argument("--planners", default=SHIPPED, help="names separated by commas")
    parser.add_argument("--ray", action="store_true", help="send tasks to the connected Ray cluster, or a local one")
    parser.add_argument("--processes", type=int, help="processes at a time; default: all cores")
    options = parser.parse_args(arguments)
    if options.ray:
        from ray.util.multiprocessing import Pool
    else:
        Pool = multiprocessing.get_context("spawn").Pool
    budgets_s = [float(budget_ms) / 1000 for budget_ms in options.budgets_ms.split(",")]
    planners = options.planners.split(",")
    task = functools.partial(measured, planners=planners, missions=options.missions, budgets_s=budgets_s)
    try:
        cells = profile_cells(*options.cells.split(","))
        with Pool(options.processes) as pool:
            parts = pool.map(task, cells, chunksize=1)
        whole = Profile.merge(map(Profile, parts))
    except MissionError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    pathlib.Path(options.profile).write_text(whole.text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
