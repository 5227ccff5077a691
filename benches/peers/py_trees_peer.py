"""Measures py_trees at the work that Apex's benches do, as far as behaviour trees can do it.

A behaviour tree has no events: a change of the blackboard is seen by the next tick, which walks the tree. So an event
here is one blackboard write and one tick. Prints one JSON object: row -> count -> nanoseconds (bytes for memory).
"""

import gc
import json
import operator
import statistics
import sys
import time
import tracemalloc

import py_trees
from py_trees.behaviours import CheckBlackboardVariableValue, Running, Success
from py_trees.common import ComparisonExpression, ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence

COUNTS = (100, 1_000, 10_000)
SECONDS_PER_ROW = 3.0


class Command(py_trees.behaviour.Behaviour):
    """Notes that it acted, as a behaviour that sends a command would."""

    sent = 0

    def update(self) -> Status:
        Command.sent += 1
        return Status.SUCCESS


def writer(*names: str) -> py_trees.blackboard.Client:
    """Return a client that may write the variables."""
    client = py_trees.blackboard.Client(name="writer")
    for name in names:
        client.register_key(key=name, access=py_trees.common.Access.WRITE)
        client.set(name, 0)
    return client


def check(variable: str, threshold: int) -> CheckBlackboardVariableValue:
    """Return a condition on one variable."""
    expression = ComparisonExpression(variable=variable, value=threshold, operator=operator.gt)
    return CheckBlackboardVariableValue(name=f"{variable}>{threshold}", check=expression)


def watchers(conditions) -> Parallel:
    """Return a tree of parallel watchers, each of which waits for its condition and then acts."""
    root = Parallel(name="all", policy=ParallelPolicy.SuccessOnAll(synchronise=False))
    for condition in conditions:
        root.add_child(Sequence(name="watch", memory=False, children=[condition, Command(name="act")]))
    return root


def median_ns(events) -> float:
    """Return the median time of `events`, each a pair of a set-up (not measured) and the measured call."""
    times = []
    until = time.perf_counter() + SECONDS_PER_ROW
    for set_up, measured in events:
        set_up()
        start = time.perf_counter_ns()
        measured()
        times.append(time.perf_counter_ns() - start)
        if time.perf_counter() > until and len(times) >= 5:
            break
    return statistics.median(times)


def event_to_command(count: int) -> float:
    """Return the time from one of `count` variables passing its threshold to the command of its watcher."""
    names = [f"level{number}" for number in range(count)]
    client = writer(*names)
    root = watchers(check(name, 10) for name in names)
    root.tick_once()

    def events():
        for number in range(10**9):
            name = names[number * 7_919 % count]
            before = Command.sent

            def event(name=name):
                client.set(name, 11)
                root.tick_once()

            yield (lambda: None), event
            assert Command.sent == before + 1, "the watcher did not act"
            client.set(name, 0)

    return median_ns(events())


def shared_variable(count: int) -> float:
    """Return the time of a sample that `count` watchers compare with separate thresholds; one of them acts."""
    client = writer("level")
    root = watchers(check("level", threshold) for threshold in range(count))
    root.tick_once()

    def events():
        while True:
            before = Command.sent

            def event():
                client.set("level", 1)
                root.tick_once()

            yield (lambda: client.set("level", 0)), event
            assert Command.sent == before + 1, "one watcher should act"

    return median_ns(events())


def life(count: int) -> float:
    """Return the time of one behaviour in a sequence of `count` behaviours that finish at once."""
    root = Sequence(name="chain", memory=True, children=[Success(name=f"s{number}") for number in range(count)])

    def events():
        while True:
            yield (lambda: root.stop(Status.INVALID)), root.tick_once
            assert root.status == Status.SUCCESS

    return median_ns(events()) / count


def hand_off(count: int) -> float:
    """Return the time in which one of `count` competitors interrupts the task that runs, ends, and that task continues."""
    names = [f"wants{number}" for number in range(count)]
    client = writer(*names)
    rivals = [
        Sequence(name=name, memory=False, children=[check(name, 0), Running(name="hold")]) for name in names
    ]
    root = Selector(name="by priority", memory=False, children=[*rivals, Running(name="default")])
    root.tick_once()

    def events():
        for number in range(10**9):
            name = names[number * 7_919 % count]

            def event(name=name):
                client.set(name, 1)
                root.tick_once()
                assert root.current_child.name == name
                client.set(name, 0)
                root.tick_once()

            yield (lambda: None), event

    return median_ns(events())


def memory(count: int) -> float:
    """Return the bytes of one waiting watcher with its condition and its action."""
    names = [f"level{number}" for number in range(count)]
    writer(*names)
    gc.collect()
    tracemalloc.start()
    root = watchers(check(name, 10) for name in names)
    root.tick_once()
    size, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return size / count


ROWS = {
    "event to command": event_to_command,
    "shared variable": shared_variable,
    "task life": life,
    "hand-off": hand_off,
    "memory": memory,
}


def main() -> None:
    """Measures every row at every count."""
    py_trees.logging.level = py_trees.logging.Level.ERROR
    results: dict[str, dict[str, float]] = {}
    for row, measure in ROWS.items():
        results[row] = {}
        for count in COUNTS:
            py_trees.blackboard.Blackboard.clear()
            results[row][str(count)] = measure(count)
            print(f"{row} {count}: {results[row][str(count)]:.0f}", file=sys.stderr)
    json.dump({"name": "py_trees", "version": py_trees.version.__version__, "rows": results}, sys.stdout)


if __name__ == "__main__":
    main()
