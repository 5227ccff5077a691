"""Plans the orienteering problems of a folder with PyVRP or OR-Tools, at equal processor time.

Both maximise profit before they shorten ways: PyVRP by prizes larger than any way (`unit_distance_cost=1`), OR-Tools by
penalties for targets left out; of three scales of the penalties, each with the whole time, the best counts. Limits are
processor time, as for Apex. Prints one JSON object: problem -> seconds -> profit. Arguments: the folder, `pyvrp` or
`ortools`, seconds.
"""

import json
import pathlib
import sys
import time

import pyvrp
from ortools.constraint_solver import pywrapcp, routing_enums_pb2

SCALES = (1, 100, 10_000)


class ProcessorTime:
    """Stops PyVRP after some processor time."""

    def __init__(self, seconds: float) -> None:
        self.until = time.process_time() + seconds

    def __call__(self, best_cost: float) -> bool:
        return time.process_time() >= self.until

    def fraction_remaining(self) -> float | None:
        return None


def of_pyvrp(problem: dict, seconds: float) -> int:
    """Return the profit of PyVRP's route."""
    targets, legs, limit = problem["targets"], problem["legs"], problem["limit"]
    dear = limit + 1
    model = pyvrp.Model()
    places = [model.add_location(0, 0) for _ in legs]
    depot = model.add_depot(places[0])
    for place, target in zip(places[1:], targets, strict=True):
        model.add_client(
            place,
            service_duration=target["service"],
            tw_early=target["opens"],
            tw_late=target["closes"],
            prize=target["profit"] * dear,
            required=False,
        )
    model.add_vehicle_type(1, start_depot=depot, end_depot=depot, tw_early=0, tw_late=limit, unit_distance_cost=1)
    for row, start in zip(legs, places, strict=True):
        for leg, end in zip(row, places, strict=True):
            if start is not end:
                model.add_edge(start, end, distance=leg, duration=leg)
    result = model.solve(stop=ProcessorTime(seconds), seed=1, display=False)
    if not result.best.is_feasible():
        return 0
    return result.best.prizes() // dear


def of_ortools(problem: dict, seconds: float, scale: int) -> int:
    """Return the profit of the route of OR-Tools with penalties of this scale."""
    targets, legs, limit = problem["targets"], problem["legs"], problem["limit"]
    manager = pywrapcp.RoutingIndexManager(len(legs), 1, 0)
    routing = pywrapcp.RoutingModel(manager)
    stays = [0] + [target["service"] for target in targets]
    way = routing.RegisterTransitMatrix(legs)
    routing.SetArcCostEvaluatorOfAllVehicles(way)
    lasting = routing.RegisterTransitMatrix([[leg + stay for leg in row] for row, stay in zip(legs, stays, strict=True)])
    routing.AddDimension(lasting, limit, limit, False, "time")
    clock = routing.GetDimensionOrDie("time")
    for number, target in enumerate(targets, start=1):
        index = manager.NodeToIndex(number)
        clock.CumulVar(index).SetRange(target["opens"], max(target["opens"], target["closes"]))
        routing.AddDisjunction([index], target["profit"] * scale)
    until = time.process_time() + seconds
    routing.AddSearchMonitor(routing.solver().CustomLimit(lambda: time.process_time() >= until))
    search = pywrapcp.DefaultRoutingSearchParameters()
    search.first_solution_strategy = routing_enums_pb2.FirstSolutionStrategy.PARALLEL_CHEAPEST_INSERTION
    search.local_search_metaheuristic = routing_enums_pb2.LocalSearchMetaheuristic.GUIDED_LOCAL_SEARCH
    search.time_limit.FromSeconds(int(20 * seconds))
    solution = routing.SolveWithParameters(search)
    if solution is None:
        return 0
    profit, index = 0, routing.Start(0)
    while not routing.IsEnd(index):
        node = manager.IndexToNode(index)
        profit += targets[node - 1]["profit"] if node else 0
        index = solution.Value(routing.NextVar(index))
    return profit


def main() -> None:
    """Plans every problem of the folder."""
    folder, peer, spans = pathlib.Path(sys.argv[1]), sys.argv[2], [int(word) for word in sys.argv[3:]]
    found: dict = {}
    for path in sorted(folder.glob("*.json")):
        if path.stem in ("ours", "pyvrp", "ortools"):
            continue
        problem = json.loads(path.read_text())
        rows = found[path.stem] = {}
        for seconds in spans:
            if peer == "pyvrp":
                rows[str(seconds)] = of_pyvrp(problem, seconds)
            else:
                rows[str(seconds)] = max(of_ortools(problem, seconds, scale) for scale in SCALES)
        print(path.stem, rows, file=sys.stderr)
    print(json.dumps(found))


main()
