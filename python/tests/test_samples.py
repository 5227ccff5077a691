"""Arrays of samples: what was not measured is refused or counts as missing, in arrays as in single samples."""

import threading
import warnings

import numpy as np
import pytest

from apex_autonomy import InputError, Monitor, Quantity, Symbol

UNITS = "(state-variable (age ?fix) :unit s) (state-variable (height ?uav) :unit m)"


def found(condition, t, values):
    """Return the first instants of the results, and the monitor."""
    monitor = Monitor(condition, library=UNITS)
    results = [*monitor.extend(t, values), *monitor.finish()]
    return [result.start_s for result in results], monitor


def test_masked_values_are_missing_and_masked_instants_are_refused():
    starts, monitor = found("(rssi modem < 20)", [0.0, 1.0, 2.0], np.ma.array([30, 10, 15], mask=[0, 1, 0]))
    assert starts == [2.0]
    assert monitor.counts()["missing"] == 1
    with pytest.raises(InputError, match="masked"):
        Monitor("(rssi modem < 20)").extend(np.ma.array([0.0, 1.0], mask=[0, 1]), [1.0, 2.0])
    armed = np.ma.array([True, True], mask=[True, False])
    assert found("(armed uav = t)", [0.0, 1.0], armed)[0] == [1.0]


@pytest.mark.parametrize(
    "values",
    [
        np.array(["30", "10"]),
        np.array([b"30", b"10"]),
        np.array(["2020-01-01", "1970-01-05"], dtype="datetime64[D]"),
        np.array([(1, 2.0), (3, 4.0)], dtype="i4,f8"),
    ],
)
def test_text_dates_and_records_are_refused(values):
    monitor = Monitor("(rssi modem < 20)")
    with pytest.raises(InputError, match="a value is not a number"):
        monitor.extend([0.0, 1.0], values)
    assert monitor.now_ns is None


@pytest.mark.parametrize(
    ("condition", "values"),
    [
        # What pandas makes of booleans with a gap.
        ("(armed uav = t)", np.array([True, None, False, True], dtype=object)),
        ("(age fix > 1s)", np.array([500, 1500, "NaT", 2500], dtype="timedelta64[ms]")),
        ("(height uav > 1km)", np.array([Quantity(1, "m"), Quantity(2, "km"), None, Quantity(4000, "m")])),
        ("(mode uav = auto)", np.array([Symbol("auto"), Symbol("manual"), Symbol("AUTO"), None])),
        ("(rssi modem < 20)", np.array([30, None, 10.5, np.float32(3)], dtype=object)),
        ("(n uav = 9007199254740993)", np.array([2**53, 2**53 + 1, 0, 1])),
        ("(n uav = -9007199254740993)", np.array([-(2**53), -(2**53) - 1, 0, 1])),
        ("(n uav > 1)", np.array([0, 1, 2, 3], dtype=np.uint8)),
    ],
)
def test_an_array_gives_the_same_as_its_items_one_by_one(condition, values):
    t = [0.0, 1.0, 2.0, 3.0]
    starts, whole = found(condition, t, values)
    single, pushed = Monitor(condition, library=UNITS), []
    for at, value in zip(t, values, strict=True):
        is_missing = value is None or (isinstance(value, np.timedelta64) and np.isnat(value))
        pushed += single.push(at, None if is_missing else value)
    assert starts == [result.start_s for result in [*pushed, *single.finish()]]
    assert starts
    assert whole.counts() == single.counts()


@pytest.mark.parametrize(
    ("instants", "words"),
    [
        (["0", "1"], "not a number of seconds"),
        ([False, True], "not a number of seconds"),
        (np.array([0, "1"], dtype=object), "not a number of seconds: '1'"),
        (np.array([0.0, None], dtype=object), "not a number of seconds: None"),
        (np.array([0, 1], dtype="timedelta64"), "have no unit"),
        (np.array([0, 1], dtype="timedelta64[M]"), "no fixed length"),
        (np.array([0, "NaT"], dtype="timedelta64[s]"), "not a time"),
    ],
)
def test_instants_that_are_no_instants_are_refused(instants, words):
    with pytest.raises(InputError, match=words):
        Monitor("(rssi modem < 20)").extend(instants, [1.0, 2.0])


def test_a_wrong_object_leaves_out_all_samples_of_the_call():
    monitor = Monitor("(rssi modem < 20)")
    with pytest.raises(InputError, match="PDL has no value like"):
        monitor.extend([0.0, 1.0, 2.0], np.array([30, 10, object()], dtype=object))
    assert monitor.now_ns is None
    assert monitor.counts()["kept"] == 0


def test_durations_need_a_unit_of_fixed_length():
    for duration in [np.timedelta64(2), np.timedelta64(2, "M"), np.timedelta64(2, "Y")]:
        with pytest.raises(InputError, match="a duration needs a unit of fixed length"):
            Monitor("(age fix > 1s)", library=UNITS).push(1, duration)
        with pytest.raises(InputError, match="a value is not a duration"):
            Monitor("(age fix > 1s)", library=UNITS).extend([1], np.array([duration]))


def test_single_values_that_are_no_values_are_input_errors():
    monitor = Monitor("(n uav > 1)")
    for value in [np.uint64(2**64 - 1), 2**64, np.datetime64("2026-01-01"), np.array([1.0, 2.0])]:
        with pytest.raises(InputError):
            monitor.push(1, value)
    assert len(monitor.push(1, np.array(2.5))) == 1
    with pytest.raises(InputError, match="beyond the range"):
        Quantity(10**400, "m")
    for name in ["", "(x)", "1", "A B", '"a"']:
        with pytest.raises(InputError, match="is not a name of PDL"):
            Symbol(name)
    assert [Symbol(name).name for name in ["AUTO", "camera-1", "nil", "t"]] == ["AUTO", "camera-1", "nil", "t"]


def test_messages_begin_with_a_word():
    monitor = Monitor("(ready ?who)")
    for form in [["ready", "camera-1"], [], "()", None, 5]:
        with pytest.raises(InputError, match="is not a message"):
            monitor.event(1, form)
    assert len(monitor.event(1, [Symbol("ready"), Symbol("camera-1")])) == 1


def test_a_variable_that_the_condition_does_not_read_is_reported_once():
    monitor = Monitor("(rssi modem < 20)")
    with pytest.warns(UserWarning, match=r"does not read \(rssy modem\).*it reads rssi"):
        monitor.push(1, 10, variable="(rssy modem)")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        monitor.push(2, 10, variable="(rssy modem)")
        monitor.push(3, 10, variable="(rssi modem)")
    declared = "(state-variable (half ?m) :derived (/ (rssi ?m) 2))"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Monitor("(half modem < 20)", library=declared).push(1, 10, variable="(rssi modem)")


def test_calls_of_several_threads_follow_each_other():
    monitor = Monitor("(rssi modem < 20)")
    t = np.arange(20_000.0)
    errors = []

    def feed(first):
        try:
            for start in range(first, 20_000, 400):
                monitor.extend(t[start : start + 100], np.full(100, 30.0))
                monitor.status()
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=feed, args=(first,)) for first in (0, 100, 200, 300)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []
    assert monitor.now_ns == 19_999 * 10**9
