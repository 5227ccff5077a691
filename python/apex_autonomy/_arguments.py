"""Arguments that must be whole numbers in a range."""

from __future__ import annotations

import operator
from typing import Any

from apex_autonomy._apex import InputError

#: The largest seed.
SEED_MAX = 2**64 - 1


def whole(name: str, value: Any, least: int, most: int) -> int:
    """Return a whole number in a range.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : object
        The argument: an ``int``, or a whole number of another library.
    least, most : int
        The smallest and the largest number that is permitted.

    Returns
    -------
    int
        The number.

    Raises
    ------
    InputError
        The argument is not a whole number, or is out of range.

    Examples
    --------
    >>> whole("runs", 3, 1, 100)
    3
    """
    try:
        number = None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        number = None
    if number is None or not least <= number <= most:
        raise InputError(f"`{name}` is {value!r}: write a whole number from {least} to {most}")
    return number


def seed_of(value: Any) -> int | None:
    """Return a seed, or None for the mission's.

    Parameters
    ----------
    value : object
        The argument `seed`.

    Returns
    -------
    int or None
        The seed.

    Raises
    ------
    InputError
        The argument is not a whole number, or is out of range.
    """
    return None if value is None else whole("seed", value, 0, SEED_MAX)
