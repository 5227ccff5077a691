"""Monitors in typical uses, and with mistakes of their users."""

from datetime import timedelta

import numpy as np
import pytest

import apex_autonomy
from apex_autonomy import ConditionError, InputError, Monitor, Quantity, Symbol, Variable, to_arrow

WINGS = "(:episode (roll-angle uav) :quality (:max-gap 1s) :value (> 15) :timing (:duration (>= 2s)))"


def runs_above(t, values, limit, gap, least):
    """Return the first and last instant of each maximal run that lasts at least `least` by its samples."""
    runs, start, last = [], None, None
    for at, value in zip(t, values, strict=True):
        if start is not None and (value <= limit or at - last > gap):
            runs.append((start, last))
            start = None
        if value > limit:
            start, last = (at, at) if start is None else (start, at)
    if start is not None:
        runs.append((start, last))
    return [(start, last) for start, last in runs if last - start >= least]


@pytest.mark.parametrize("seed", range(20))
def test_arrays_samples_and_pieces_tell_the_same_as_the_definition(seed):
    random = np.random.default_rng(seed)
    t_ns = np.cumsum(random.integers(1, 4, 400)) * 400_000_000
    values = np.where(np.cumsum(random.integers(0, 8, 400) == 0) % 2, 20.0, 10.0)
    stamps = t_ns.astype("timedelta64[ns]")

    whole = Monitor(WINGS)
    closed = [*whole.extend(stamps, values), *whole.finish()]
    final = [(result.start_ns, result.end_ns) for result in closed if not result.open]

    pieces, told = Monitor(WINGS), []
    for part in np.array_split(np.arange(400), 23):
        told += pieces.extend(stamps[part], values[part])
    told += pieces.finish()
    assert [(r.start_ns, r.end_ns, r.recognised_at_ns) for r in told] == [
        (r.start_ns, r.end_ns, r.recognised_at_ns) for r in closed
    ]

    single, told = Monitor(WINGS), []
    for at, value in zip(stamps, values, strict=True):
        told += single.push(at, value)
    told += single.finish()
    assert [(r.start_ns, r.end_ns) for r in told if not r.open] == final

    # A run can also be recognised after its last sample, within the gap, and is then shorter by its samples.
    expected = runs_above(t_ns, values, 15, 10**9, 2 * 10**9)
    assert [run for run in final if run[1] - run[0] >= 2 * 10**9] == expected


def test_booleans_in_arrays_stay_booleans():
    t, armed = [0.0, 1.0, 2.0, 3.0], np.array([False, True, True, False])
    whole, single = Monitor("(armed uav = t)"), Monitor("(armed uav = t)")
    told = [*whole.extend(t, armed), *whole.finish()]
    for at, value in zip(t, armed.tolist(), strict=True):
        single.push(at, value)
    assert [result.start_s for result in told] == [1.0, 2.0]
    assert whole.status().verdict == single.status().verdict == "satisfied"
    # Numbers stay numbers.
    numbers = Monitor("(armed uav = t)")
    numbers.extend(t, armed.astype(float))
    assert numbers.finish().column("start_ns").size == 0
    with pytest.raises(InputError, match="4 instants for 1 values"):
        Monitor("(armed uav = t)").extend(t, np.array([True]))


def test_instants_with_units_are_exact():
    monitor = Monitor("(rssi modem < 20)")
    at = np.timedelta64(1_234_567_890_123_456_789, "ns")
    assert monitor.push(at, 3)[0].start_ns == 1_234_567_890_123_456_789
    assert monitor.now_ns == 1_234_567_890_123_456_789
    stamp = np.datetime64("2038-01-19T03:14:08.000000001")
    assert monitor.push(stamp, 3)[0].start_ns == 2_147_483_648_000_000_001
    assert Monitor("(rssi modem < 20)").push(timedelta(minutes=1), 3)[0].start_s == 60.0


def test_created_hides_what_came_before():
    t, values = [0.0, 1.0, 2.0, 3.0], [5.0, 30.0, 7.0, 30.0]
    assert [r.start_s for r in Monitor("(rssi modem < 20)").extend(t, values)] == [0.0, 2.0]
    assert [r.start_s for r in Monitor("(rssi modem < 20)", created=1).extend(t, values)] == [2.0]


def test_units_come_from_the_library(tmp_path):
    path = tmp_path / "terms.pdl"
    path.write_text("(state-variable (altitude ?) :unit ft)\n")
    monitor = Monitor("(altitude uav > 400ft)", library=path)
    assert len(monitor.push(1, 399)) == 0
    assert len(monitor.push(2, Quantity(125, "m"))) == 1
    (fact,) = monitor.push(3, 500)[0].evidence
    assert (fact.kind, fact.variable, fact.value.unit, round(fact.value.value)) == (
        "sample",
        "(altitude uav)",
        "ft",
        500,
    )


def test_tags_and_variables_are_bindings():
    monitor = Monitor("(:and (:measurement ?low (rssi ?who) :value (< 20)) (ready ?who))")
    monitor.push(1, 10, variable="(rssi modem-2)")
    assert len(monitor.event(2, "(ready modem-1)")) == 0
    (result,) = monitor.event(3, "(ready modem-2)")
    assert result.bindings["who"] == Symbol("modem-2")
    assert result.bindings["low"].start_s == 1.0


def test_results_are_an_arrow_table():
    monitor = Monitor("(rssi modem < 20)")
    table = to_arrow(monitor.extend(np.arange(5.0), [1, 30, 2, 30, 30]))
    assert table.num_rows == 2
    assert str(table.schema.field("start").type) == "duration[ns]"
    assert table.column("start").cast("int64").to_pylist() == [0, 2_000_000_000]
    assert table.column("evidence").to_pylist()[1] == "(rssi modem) = 2.0 at 2s"


def test_what_is_unknown_says_why():
    monitor = Monitor(WINGS)
    assert monitor.status().verdict == "unknown"
    monitor.push(0, 20)
    monitor.push(5, 20)
    status = monitor.status()
    assert status.verdict == "unknown"
    assert "gap" in str(status)


def test_late_samples_are_counted_and_told():
    monitor = Monitor("(rssi modem < 20)")
    monitor.push(5, 30)
    assert len(monitor.push(4, 3)) == 0
    assert monitor.counts()["late"] == 1
    (error,) = monitor.errors()
    assert "too late" in error and monitor.errors() == []


@pytest.mark.parametrize(
    ("condition", "words"),
    [
        ("(altitude uav >", "1:1"),
        ("(:episode (a x) :value (> 1))", ":quality"),
        ("", "no condition"),
        ("(a x > 1) (b x > 1)", "several"),
        ("(a x > 3 furlongs)", "furlongs"),
    ],
)
def test_wrong_conditions_say_what_and_where(condition, words):
    with pytest.raises(ConditionError, match="(?s).*" + words):
        Monitor(condition)


def test_wrong_input_is_refused_and_changes_nothing():
    monitor = Monitor("(:and (a x > 1) (b x > 1))")
    with pytest.raises(InputError, match=r"say which variable .* \(a x\) \(b x\)"):
        monitor.push(1, 2)
    with pytest.raises(InputError, match="not a state variable"):
        monitor.push(1, 2, variable="(((")
    with pytest.raises(InputError, match="PDL has no value like"):
        monitor.push(1, object(), variable="(a x)")
    with pytest.raises(InputError, match="not a number"):
        monitor.push(float("nan"), 2, variable="(a x)")
    with pytest.raises(InputError, match="2 instants for 3 values"):
        monitor.extend([1, 2], [1, 2, 3], variable="(a x)")
    with pytest.raises(InputError, match="nanoseconds"):
        monitor.extend([1.7e18], [1], variable="(a x)")
    with pytest.raises(InputError, match="there is no unit"):
        Quantity(1, "furlong")
    assert monitor.now_ns is None


def test_strided_arrays_and_integers_are_taken():
    monitor = Monitor("(a x > 1)")
    values = np.arange(20)[::2]
    assert len(monitor.extend(np.arange(20)[::2], values)) + len(monitor.finish()) == 9


def test_the_largest_gap_is_told_where_it_is_asked_for():
    condition = "(:episode (rssi uav) :quality :no-constraints :value (< 20))"
    t, rssi = [1.0, 2.0, 6.0, 6.5, 7.0, 30.0], [15.0, 12.0, 14.0, 11.0, 40.0, 40.0]
    silent, telling = Monitor(condition), Monitor(condition, gaps=True)
    for monitor, gap_s_max in ((silent, None), (telling, 4.0)):
        results = [*monitor.extend(t, rssi), *monitor.finish()]
        assert results[-1].gap_s_max == gap_s_max
        assert (results[-1].start_s, results[-1].end_s) == (1.0, 6.5)
    alone = Monitor(condition, gaps=True)
    assert [result.gap_s_max for result in [*alone.push(1, 15.0), *alone.finish()]][-1] is None


def test_variables_and_symbols_are_values():
    assert Variable("(a x)") == Variable("(A X)")
    assert len({Symbol("a"), Symbol("A")}) == 1
    assert Symbol("a") != "a"


def test_every_public_thing_says_what_it_is():
    for name in apex_autonomy.__all__:
        if name != "__version__":
            assert getattr(apex_autonomy, name).__doc__, name


def test_derived_state_variables_are_computed_over_all_inputs():
    library = "(state-variable (error ?a) :derived (abs (- (want ?a) (roll ?a))) :join (:hold 1s))"
    condition = "(:episode (error uav) :quality (:max-gap 1s) :value (> 10) :timing (:duration (>= 1s)))"
    monitor = Monitor(condition, library=library)
    # The variables alternate, so at each instant the older value is held: |0-3|, |20-3|, |20-8|, |20-8|, |20-19|.
    samples = [(1.0, "roll", 3), (1.5, "want", 20), (2.0, "roll", 8), (2.5, "want", 20), (3.0, "roll", 19)]
    found = list(monitor.push(0.5, 0, variable="(want uav)"))
    for at, name, value in samples:
        found += monitor.push(at, value, variable=f"({name} uav)")
    found += monitor.finish()
    final = [(result.start_ns, result.end_ns) for result in found if not result.open]
    assert final == [(1_500_000_000, 2_500_000_000)]


def test_former_names_still_work_and_warn():
    """Names of the release before are aliases for one release."""
    monitor = Monitor("(altitude uav > 100)")
    with pytest.warns(DeprecationWarning, match="status"):
        assert monitor.judgement().verdict == monitor.status().verdict
    with pytest.warns(DeprecationWarning, match="errors"):
        assert monitor.troubles() == monitor.errors() == []
    assert apex_autonomy.Judgement is apex_autonomy.ConditionStatus


def test_instants_out_of_reach_are_refused_instead_of_wrapped_around():
    far = np.datetime64("2500-01-01")
    for instant in [far, np.timedelta64(10**12, "s"), np.datetime64("1500-01-01T00:00:00")]:
        with pytest.raises(InputError, match="too far away"):
            Monitor("(rssi m < 20)").push(instant, 1)
        with pytest.raises(InputError, match="292 years"):
            Monitor("(rssi m < 20)").extend(np.array([instant]), [1.0])
    near = Monitor("(rssi m < 20)")
    near.extend(np.array(["2026-08-01"], dtype="datetime64[D]"), [1.0])
    near.push(np.datetime64("2026-08-02"), 1)
    assert near.now_ns == np.datetime64("2026-08-02", "ns").astype(np.int64)
    fine = Monitor("(rssi m < 20)")
    fine.extend(np.array([1_500], dtype="timedelta64[ps]"), [1.0])
    fine.push(np.timedelta64(2_500, "ps"), 1)
    assert fine.now_ns == 2


def test_values_that_are_no_numbers_are_refused_and_truth_values_of_numpy_are_truth_values():
    for values in (["a", "b"], [1j, 2.0]):
        with pytest.raises(InputError, match="a value is not a number"):
            Monitor("(rssi m < 20)").extend([1, 2], values)
    with pytest.raises(InputError, match="an instant is not a number"):
        Monitor("(rssi m < 20)").extend(["noon"], [1.0])
    assert len(Monitor("(armed uav = t)").push(1, np.True_)) == 1
    circle: list = []
    circle.append(circle)
    with pytest.raises(InputError, match="contains itself"):
        Monitor("(rssi m < 20)").push(1, circle)
    with pytest.raises(InputError, match="5 is not a message"):
        Monitor("(go)").event(1, 5)
