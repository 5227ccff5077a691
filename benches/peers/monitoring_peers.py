"""Measures rtamt and reelay on the traces that Apex's monitors watch.

Each monitor watches one formula and receives one sample at a time, as the peers' documentation shows. A value episode is
the formula `x > b`; a duration episode is "x > b for the last D samples". The peers have no largest gap and give no
evidence. Prints one JSON object: peer -> rows -> nanoseconds per monitor and sample.
"""

import json
import pathlib
import statistics
import sys
import time

import reelay
import rtamt

SAMPLES = 2_000
MONITORS = 5


def trace(folder: pathlib.Path, name: str) -> list[float]:
    """Return the first samples of a trace."""
    return [float(line) for line in (folder / name).read_text().split()[:SAMPLES]]


def bounds() -> list[tuple[float, int]]:
    """Return bounds with durations in samples, spread like those of Apex's monitors."""
    return [(-20.0 + 40.0 * number / MONITORS, 25 + number * 500 // MONITORS) for number in range(MONITORS)]


def of_reelay(pattern: str, values: list[float]) -> float:
    """Return the processor time of reelay in nanoseconds per sample."""
    monitor = reelay.discrete_timed_monitor(pattern=pattern, semantics="boolean")
    samples = [{"x": value} for value in values]
    start = time.process_time_ns()
    for sample in samples:
        monitor.update(sample)
    return (time.process_time_ns() - start) / len(values)


def of_rtamt(formula: str, values: list[float]) -> float:
    """Return the processor time of rtamt in nanoseconds per sample."""
    spec = rtamt.StlDiscreteTimeSpecification()
    spec.declare_var("x", "float")
    spec.declare_var("out", "float")
    spec.spec = f"out = {formula}"
    spec.parse()
    spec.pastify()
    start = time.process_time_ns()
    for index, value in enumerate(values):
        spec.update(index, [("x", value)])
    return (time.process_time_ns() - start) / len(values)


def main() -> None:
    """Measures both peers on both traces."""
    folder = pathlib.Path(sys.argv[1])
    results: dict[str, dict] = {}
    for name, measure, version in [
        ("reelay", of_reelay, "25.0.0"),
        ("rtamt", of_rtamt, "0.4.10"),
    ]:
        rows: dict[str, float] = {}
        for signal in ("smooth", "noise"):
            values = trace(folder, signal)
            if name == "reelay":
                value = [f"x > {bound}" for bound, _ in bounds()]
                duration = [f"historically[0:{samples}]{{x > {bound}}}" for bound, samples in bounds()]
                value = [f"{{{each}}}" for each in value]
            else:
                value = [f"(x > {bound})" for bound, _ in bounds()]
                duration = [f"historically[0:{samples}](x > {bound})" for bound, samples in bounds()]
            rows[f"value {signal}"] = statistics.median(measure(each, values) for each in value)
            rows[f"duration {signal}"] = statistics.median(measure(each, values) for each in duration)
        results[name] = {"version": version, "rows": rows}
        print(name, rows, file=sys.stderr)
    json.dump(results, sys.stdout)


if __name__ == "__main__":
    main()
