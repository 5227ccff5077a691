"""Monitors: conditions of PDL over samples and messages."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Sequence
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from apex_autonomy._apex import ConditionStatus, InputError, Results, Session, Variable, instant_ns
from apex_autonomy._samples import items, nanoseconds, numbers

#: Seconds as a number, or a value with a unit.
Instant = float | int | np.timedelta64 | np.datetime64 | timedelta


class Monitor:
    """Watches one condition.

    Samples and messages are passed with their instants: seconds as a number, or ``numpy.timedelta64``,
    ``numpy.datetime64`` or ``datetime.timedelta``, which are exact to the nanosecond. All inputs of one instant form a
    step, and a call returns the results of instants that are over. So a result of the newest instant is returned by the
    next call, by :meth:`advance` or by :meth:`finish`; only :meth:`push` assumes that its instant is complete. Several
    threads may use a monitor: their calls follow each other.

    Parameters
    ----------
    condition : str
        A condition of PDL, for example ``"(altitude uav > 400ft)"``.
    library : str or pathlib.Path, optional
        Declarations of state variables, functions and constants for the condition: PDL as text, or the path of a
        file.
    created : Instant, optional
        The instant from which evidence counts, as if the task that waits for the condition were created then. By
        default everything counts.
    gaps : bool, default False
        Results contain the largest sampling gap within them, ``Result.gap_s_max``, which makes every sample slower.
        Otherwise it is None.

    Raises
    ------
    ConditionError
        The condition or the library is wrong; the text gives the place, the reason and advice.
    OSError
        The library's file cannot be read.

    Warns
    -----
    UserWarning
        For the warnings of ``apex check``.

    Examples
    --------
    A roll angle that stays above 15 degrees for two seconds, in samples not more than one second apart:

    >>> import numpy as np
    >>> from apex_autonomy import Monitor
    >>> monitor = Monitor(
    ...     "(:episode (roll-angle uav) :quality (:max-gap 1s) :value (> 15) :timing (:duration (>= 2s)))"
    ... )
    >>> t = np.arange(0.0, 10.0, 0.5)
    >>> results = monitor.extend(t, np.where((t >= 3) & (t < 7), 20.0, 0.0))
    >>> [(result.start_s, result.recognised_at_s, result.open) for result in results]
    [(3.0, 5.0, True), (3.0, 5.0, False)]
    >>> results[1].end_s
    6.5
    >>> print(results[1])
    (roll-angle uav) from 3s to 6.5s, 8 samples

    The largest time between two samples of a result:

    >>> monitor = Monitor("(:episode (rssi uav) :quality :no-constraints :value (< 20))", gaps=True)
    >>> results = monitor.extend([1.0, 2.0, 6.0, 6.5, 7.0], [15.0, 12.0, 14.0, 11.0, 40.0])
    >>> monitor.finish()[-1].gap_s_max
    4.0
    """

    def __init__(
        self,
        condition: str,
        *,
        library: str | Path | None = None,
        created: Instant | None = None,
        gaps: bool = False,
    ) -> None:
        source = folder = None
        if isinstance(library, Path):
            source, folder = (str(library), library.read_text(encoding="utf-8")), library.parent
        elif library is not None:
            source = ("the library", library)
        created_ns = None if created is None else instant_ns(created)
        self._session = Session(condition, library=source, folder=folder, created_ns=created_ns, gaps=gaps)
        self._condition = condition
        self._variables = self._session.variables
        #: Calls of several threads follow each other.
        self._lock = threading.Lock()
        #: Variables of samples so far: a variable that the condition does not read is reported once.
        self._named: set[Variable] = set()
        if self._session.warnings:
            warnings.warn(self._session.warnings, UserWarning, stacklevel=2)

    @property
    def condition(self) -> str:
        """The condition's text."""
        return self._condition

    @property
    def variables(self) -> list[Variable]:
        """The state variables that the condition names together with their objects.

        Examples
        --------
        >>> Monitor("(:and (a x > 1) (b x > 2))").variables
        [Variable("(a x)"), Variable("(b x)")]
        """
        return list(self._variables)

    @property
    def now_ns(self) -> int | None:
        """The newest instant, in nanoseconds; None before the first."""
        with self._lock:
            return self._session.now_ns

    def push(self, t: Instant, value: Any, *, variable: str | Variable | None = None) -> Results:
        """Pass one sample, the last of its instant.

        Parameters
        ----------
        t : Instant
            When it was measured. A sample earlier than the newest one is late: it counts within the ``:lateness`` of
            its variable.
        value : object
            A number (in the declared unit, if one is declared), ``bool``, ``str``, :class:`Symbol`, :class:`Quantity`,
            ``numpy.timedelta64`` or a list of such. None and not-a-number are missing measurements.
        variable : str or Variable, optional
            The measured variable, ``"(altitude uav)"``. Not needed if the condition names a single variable.

        Returns
        -------
        Results
            The new results.

        Raises
        ------
        InputError
            The value, the instant or the variable cannot be used.

        Warns
        -----
        UserWarning
            At the first sample of a variable whose attribute the condition does not read.

        Examples
        --------
        >>> monitor = Monitor("(mode uav = auto)")
        >>> from apex_autonomy import Symbol
        >>> monitor.push(1, Symbol("manual"))
        <0 results>
        >>> monitor.push(2, Symbol("AUTO"))
        <1 result>
        """
        known = self._variable(variable)
        with self._lock:
            self._session.sample(known, value, t)
            self._session.advance(t)
            return self._session.take_results()

    def extend(self, t: npt.ArrayLike, values: npt.ArrayLike, *, variable: str | Variable | None = None) -> Results:
        """Pass many samples of one variable.

        Parameters
        ----------
        t : array_like, shape (n,)
            Instants: seconds as numbers, or ``timedelta64`` / ``datetime64``.
        values : array_like, shape (n,)
            Numbers, in the declared unit if one is declared; not-a-number and masked values are missing measurements.
            Booleans, ``timedelta64``, objects, and whole numbers beyond ``2**53`` are values as in :meth:`push`, and
            take longer.
        variable : str or Variable, optional
            As in :meth:`push`.

        Returns
        -------
        Results
            The new results at instants that are over. The interpreter's lock is released meanwhile.

        Raises
        ------
        InputError
            The arrays differ in length or have more than one dimension; an instant is masked or not a time; values
            are text, dates or complex numbers, or an object is not a value of PDL. No sample is recorded then.

        Examples
        --------
        >>> monitor = Monitor("(rssi modem < 20)")
        >>> monitor.extend([0.0, 0.5, 1.0], [30.0, 18.0, 16.0]).column("start_ns")
        array([500000000])
        >>> monitor.finish().column("start_ns")
        array([1000000000])
        """
        given = values if isinstance(values, np.ma.MaskedArray) else np.asarray(values)
        instants = nanoseconds(t)
        if instants.ndim != 1 or given.ndim != 1:
            raise InputError(f"instants have {instants.ndim} dimensions, values {given.ndim}; one each is expected")
        if len(instants) != len(given):
            raise InputError(f"there are {len(instants)} instants for {len(given)} values")
        real = numbers(given)
        objects = items(given) if real is None else []
        known = self._variable(variable)
        with self._lock:
            if real is not None:
                self._session.samples(known, instants, real)
            else:
                self._session.items(known, instants, objects)
            return self._session.take_results()

    def event(self, t: Instant, form: str | Sequence[Any]) -> Results:
        """Pass a message, the last input of its instant.

        Parameters
        ----------
        t : Instant
            When the message arrived.
        form : str or list
            The message as PDL, ``"(ready camera-1)"``, or as a list of values, whose names are :class:`Symbol`:
            ``[Symbol("ready"), Symbol("camera-1")]``.

        Returns
        -------
        Results
            The new results.

        Raises
        ------
        InputError
            The form or the instant cannot be used.

        Examples
        --------
        >>> results = Monitor("(ready ?who)").event(3, "(ready camera-1)")
        >>> results[0].bindings
        {'who': Symbol("camera-1")}
        """
        with self._lock:
            self._session.event(form, t)
            self._session.advance(t)
            return self._session.take_results()

    def advance(self, t: Instant) -> Results:
        """Advance time to ``t``, after all inputs up to and including ``t`` have been passed.

        Parameters
        ----------
        t : Instant
            The instant.

        Returns
        -------
        Results
            The new results, including those that follow from time alone.

        Examples
        --------
        >>> monitor = Monitor("(:episode (a x) :quality (:max-gap 5s) :value (> 1) :timing (:duration (>= 2s)))")
        >>> monitor.push(0, 7)
        <0 results>
        >>> monitor.advance(4)[0].recognised_at_s
        2.0
        """
        with self._lock:
            self._session.advance(t)
            return self._session.take_results()

    def finish(self) -> Results:
        """End the input: the newest instant is over, and open runs end here.

        Returns
        -------
        Results
            The new results.
        """
        with self._lock:
            self._session.finish()
            return self._session.take_results()

    def status(self) -> ConditionStatus:
        """Return the status of the condition at the newest instant that is over.

        Returns
        -------
        ConditionStatus
            ``verdict``, and the parts that do not hold with the reason of each. ``str()`` gives it as text.

        Examples
        --------
        >>> monitor = Monitor("(altitude uav > 100)")
        >>> monitor.status().verdict
        'not satisfied'
        >>> monitor.push(1, 60)
        <0 results>
        >>> print(monitor.status().because[0].now)
        (altitude uav) = 60, 40 off
        """
        with self._lock:
            return self._session.status()

    def judgement(self) -> ConditionStatus:
        """Return :meth:`status`; deprecated.

        Returns
        -------
        ConditionStatus
            As :meth:`status`.
        """
        warnings.warn("Monitor.judgement() is now Monitor.status()", DeprecationWarning, stacklevel=2)
        return self.status()

    def counts(self, variable: str | Variable | None = None) -> dict[str, int]:
        """Count the uses of the samples of a variable.

        Parameters
        ----------
        variable : str or Variable, optional
            As in :meth:`push`.

        Returns
        -------
        dict
            ``kept`` samples in the history now; ``late`` ones beyond the variable's ``:lateness``, kept aside;
            ``replaced`` by another value of the same instant; ``missing`` ones (not a number).

        Examples
        --------
        >>> monitor = Monitor("(rssi modem < 20)")
        >>> _ = monitor.extend([1, 2, 2, 0, 3], [30, 30, 31, 30, float("nan")])
        >>> counts = monitor.counts()
        >>> counts["late"], counts["replaced"], counts["missing"]
        (1, 1, 1)
        """
        names = ("kept", "late", "replaced", "missing")
        known = self._variable(variable)
        with self._lock:
            return dict(zip(names, self._session.counts(known), strict=True))

    def errors(self) -> list[str]:
        """Take the errors since the last call: samples refused or too late, expressions that failed.

        Returns
        -------
        list of str
            One message each.
        """
        with self._lock:
            return self._session.take_errors()

    def troubles(self) -> list[str]:
        """Return :meth:`errors`; deprecated.

        Returns
        -------
        list of str
            As :meth:`errors`.
        """
        warnings.warn("Monitor.troubles() is now Monitor.errors()", DeprecationWarning, stacklevel=2)
        return self.errors()

    def __repr__(self) -> str:
        """Show the condition."""
        return f"Monitor({self._condition!r})"

    def _variable(self, variable: str | Variable | None) -> Variable:
        if variable is not None:
            named = variable if isinstance(variable, Variable) else Variable(variable)
            if named not in self._named:
                self._named.add(named)
                with self._lock:
                    unread = self._session.unread(named)
                if unread:
                    warnings.warn(unread, UserWarning, stacklevel=3)
            return named
        known = self._variables
        if len(known) == 1:
            return known[0]
        names = " ".join(str(each) for each in known) or "none with its object"
        raise InputError(f"say which variable was measured: variable=...; the condition names {names}")
