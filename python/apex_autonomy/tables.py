"""Results as Arrow tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

from apex_autonomy._apex import Results

if TYPE_CHECKING:
    import pyarrow

_INSTANTS: Final[tuple[Literal["start_ns", "end_ns", "recognised_at_ns"], ...]] = (
    "start_ns",
    "end_ns",
    "recognised_at_ns",
)


def to_arrow(results: Results) -> pyarrow.Table:
    """Put results into a table, with one row for each.

    Parameters
    ----------
    results : Results
        Results of :meth:`Monitor.push`, :meth:`Monitor.extend` and similar methods.

    Returns
    -------
    pyarrow.Table
        Columns ``start``, ``end`` and ``recognised_at`` (duration[ns] since the origin of the instants handed over),
        ``open`` and ``closed`` (bool, see :class:`Result`), ``evidence`` (string). Instants share their memory with
        NumPy arrays.

    Raises
    ------
    ImportError
        ``pyarrow`` is not installed: ``pip install apex-autonomy[arrow]``.

    Examples
    --------
    >>> from apex_autonomy import Monitor, to_arrow
    >>> table = to_arrow(Monitor("(rssi modem < 20)").extend([0, 1, 2, 3], [25.0, 17.0, 12.0, 25.0]))
    >>> table.column("start").to_pylist()[0].total_seconds()
    1.0
    >>> table.column("evidence")[1].as_py()
    '(rssi modem) = 12.0 at 2s'
    """
    import pyarrow

    columns = {name.removesuffix("_ns"): results.column(name).astype("timedelta64[ns]") for name in _INSTANTS}
    arrays = {name: pyarrow.array(values) for name, values in columns.items()}
    arrays["open"] = pyarrow.array(results.column("open"))
    arrays["closed"] = pyarrow.array(results.column("closed"))
    arrays["evidence"] = pyarrow.array(results.texts(), type=pyarrow.string())
    return pyarrow.table(arrays)
