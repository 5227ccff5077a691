"""Conversion of arrays to the instants and values of samples."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from apex_autonomy._apex import InputError, instant_ns

#: Whole numbers up to this one are exact as float64.
EXACT_INTEGER_MAX = 2**53
#: Classes of the markers that pandas uses for values that are not there.
MISSING_MARKERS = frozenset({"NAType", "NaTType"})


def numbers(given: npt.NDArray[Any]) -> npt.NDArray[np.float64] | None:
    """Convert values to numbers, if all of them are numbers that float64 holds exactly.

    Parameters
    ----------
    given : numpy.ndarray, shape (n,)
        Values. Masked ones are missing measurements.

    Returns
    -------
    numpy.ndarray or None
        Not-a-number for missing measurements. None if the values have to be passed one at a time, see :func:`items`.

    Raises
    ------
    InputError
        The values are of a kind that is not measured: text, dates, complex numbers, records.

    Examples
    --------
    >>> numbers(np.ma.array([30, 10], mask=[False, True]))
    array([30., nan])
    >>> numbers(np.array([True, False])) is None
    True
    """
    if given.dtype.kind not in "biufmO":
        raise InputError(
            f"a value is not a number: the array is of type {given.dtype}; convert text with astype(float), pass dates "
            "as instants"
        )
    if given.dtype.kind not in "iuf":
        return None
    bare = np.ma.getdata(given)
    if given.dtype.kind in "iu" and bare.size:
        # Negation of the least integer wraps around.
        least, most = int(bare.min()), int(bare.max())
        if least < -EXACT_INTEGER_MAX or most > EXACT_INTEGER_MAX:
            return None
    real = bare.astype(np.float64)
    if np.ma.is_masked(given):
        real[np.ma.getmaskarray(given)] = np.nan
    return np.ascontiguousarray(real)


def items(given: npt.NDArray[Any]) -> list[Any]:
    """Return the values one at a time, as :meth:`Monitor.push` takes them; None is a missing measurement.

    Parameters
    ----------
    given : numpy.ndarray, shape (n,)
        Values. Masked ones, not-a-time and the markers of pandas are missing measurements.

    Returns
    -------
    list
        The values.

    Raises
    ------
    InputError
        Durations without a unit, or in months or years, which have no fixed length.

    Examples
    --------
    >>> items(np.array([True, None, 2], dtype=object))
    [True, None, 2]
    """
    if given.dtype.kind == "m":
        _refuse_durations_without_length(given, "a value")
        masked = np.ma.getmaskarray(given) | np.isnat(np.ma.getdata(given))
        return [None if is_missing else each for each, is_missing in zip(np.ma.getdata(given), masked, strict=True)]
    masked = np.ma.getmaskarray(given)
    bare = np.ma.getdata(given).tolist()
    return [None if is_missing or _is_marker(each) else each for each, is_missing in zip(bare, masked, strict=True)]


def nanoseconds(given: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """Convert instants to whole nanoseconds.

    Parameters
    ----------
    given : array_like, shape (n,)
        Seconds as numbers, ``timedelta64``, ``datetime64``, or objects of these kinds.

    Returns
    -------
    numpy.ndarray
        Nanoseconds as int64.

    Raises
    ------
    InputError
        An instant is masked, not a time, no number, or more than 292 years from the origin.

    Examples
    --------
    >>> nanoseconds([0.0, 1.5])
    array([         0, 1500000000])
    """
    t = np.ma.asanyarray(given) if isinstance(given, np.ma.MaskedArray) else np.asarray(given)
    if np.ma.is_masked(t):
        raise InputError("an instant is masked; leave out the samples without an instant")
    t = np.ma.getdata(t)
    if t.dtype.kind in "mM":
        return _exact_nanoseconds(t)
    if t.dtype.kind == "O":
        return np.array([_object_ns(each) for each in t.ravel()], dtype=np.int64).reshape(t.shape)
    # NumPy makes an empty list an array of numbers.
    if t.dtype.kind not in "iuf":
        raise InputError(f"an instant is not a number of seconds: the array is of type {t.dtype}")
    seconds = t.astype(np.float64)
    if not np.isfinite(seconds).all():
        raise InputError("an instant is not a finite number of seconds")
    if np.abs(seconds).max(initial=0.0) > 9.2e9:
        raise InputError(
            "an instant is more than 292 years from the origin: are these nanoseconds? use timedelta64[ns]"
        )
    return np.ascontiguousarray(np.rint(seconds * 1e9).astype(np.int64))


def _exact_nanoseconds(t: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    unit = "timedelta64[ns]" if t.dtype.kind == "m" else "datetime64[ns]"
    if t.dtype.kind == "m":
        _refuse_durations_without_length(t, "an instant")
    if np.isnat(t).any():
        raise InputError("an instant is not a time (NaT)")
    exact = t.astype(unit)
    # NumPy wraps around silently. Units finer than nanoseconds lose digits, but are never out of reach.
    if np.datetime_data(t.dtype)[0] not in {"ps", "fs", "as"} and not np.array_equal(exact.astype(t.dtype), t):
        raise InputError("an instant is more than 292 years from the origin")
    return np.ascontiguousarray(exact.astype(np.int64))


def _object_ns(instant: Any) -> int:
    if isinstance(instant, (bool, np.bool_, str, bytes)) or instant is None or _is_marker(instant):
        raise InputError(f"an instant is not a number of seconds: {instant!r}")
    return instant_ns(instant)


def _refuse_durations_without_length(given: npt.NDArray[Any], what: str) -> None:
    unit = np.datetime_data(given.dtype)[0]
    if unit in {"generic", "M", "Y"}:
        why = "have no unit" if unit == "generic" else "are in months or years, which have no fixed length"
        raise InputError(f"{what} is not a duration: the durations {why}; write, for example, timedelta64[ms]")


def _is_marker(value: Any) -> bool:
    return type(value).__name__ in MISSING_MARKERS
