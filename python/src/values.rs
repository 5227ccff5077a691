//! Conversion between values of PDL and values of Python.

use crate::errors::input;
use apex_model::event::StateVariable;
use apex_model::quantity::{self, UNITS, unit_named};
use apex_model::symbol;
use apex_model::time::{Duration, NANOSECONDS_PER_SECOND, Time};
use apex_model::value::Value;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat, PyInt, PyList, PyString, PyTuple};

/// A name of PDL, in contrast to a string: ``Symbol("auto")`` is ``auto``, ``"auto"`` is ``"auto"``.
///
/// Symbols are equal in any case.
///
/// Parameters
/// ----------
/// name : str
///     The name.
///
/// Raises
/// ------
/// InputError
///     PDL cannot write the name as a symbol.
#[pyclass(frozen, eq, hash, from_py_object, module = "apex_autonomy")]
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct Symbol(symbol::Symbol);

#[pymethods]
impl Symbol {
    #[new]
    fn new(name: &str) -> PyResult<Symbol> {
        match apex_pdl::read_value(name) {
            // As a value it is the empty list.
            _ if name.eq_ignore_ascii_case("nil") => Ok(Symbol(symbol::Symbol::new(name))),
            Ok(Value::Symbol(symbol)) if symbol.to_string() == name => Ok(Symbol(symbol)),
            _ => Err(input(format!(
                "{name:?} is not a name of PDL: write letters, digits and hyphens, without spaces, quotes or parentheses"
            ))),
        }
    }

    /// str: The name as written.
    #[getter]
    fn name(&self) -> String {
        self.0.to_string()
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        format!("Symbol({:?})", self.0.to_string())
    }
}

/// A number with its unit.
///
/// Parameters
/// ----------
/// value : float
///     The number.
/// unit : str
///     A unit of PDL, for example ``"deg"``, ``"kt"``, ``"ft"``.
///
/// Raises
/// ------
/// InputError
///     The number is too large; the unit is unknown, or is a unit of time: use ``numpy.timedelta64``.
#[pyclass(frozen, from_py_object, module = "apex_autonomy")]
#[derive(Clone)]
pub(crate) struct Quantity(quantity::Quantity);

#[pymethods]
impl Quantity {
    #[new]
    fn new(value: &Bound<'_, PyAny>, unit: &str) -> PyResult<Quantity> {
        let value: f64 = value.extract().map_err(|error: PyErr| {
            let is_large = error.is_instance_of::<PyOverflowError>(value.py());
            if is_large { input(format!("{value} is beyond the range of numbers")) } else { error }
        })?;
        match unit_named(unit) {
            Some(found) if found.dimension == quantity::Dimension::TIME => {
                Err(input(format!("{unit} is a unit of time: hand over a numpy.timedelta64 instead")))
            }
            Some(found) => Ok(Quantity(quantity::Quantity::of(value, found))),
            None => {
                let known: Vec<&str> = UNITS.iter().map(|unit| unit.name).collect();
                Err(input(format!("there is no unit called {unit:?}; there are: {}", known.join(" "))))
            }
        }
    }

    /// float: The number, in :attr:`unit`.
    #[getter]
    fn value(&self) -> f64 {
        self.0.unit().map_or(self.0.si, |unit| self.0.in_unit(unit))
    }

    /// str: The unit; SI base units where there is no unit of that dimension.
    #[getter]
    fn unit(&self) -> String {
        self.0.unit().map_or_else(|| self.0.dimension.to_string(), |unit| unit.name.to_string())
    }

    /// float: The number in SI units.
    #[getter]
    fn si(&self) -> f64 {
        self.0.si
    }

    fn __eq__(&self, other: &Quantity) -> bool {
        self.0 == other.0
    }

    fn __hash__(&self) -> u64 {
        self.0.si.to_bits()
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        format!("Quantity({}, {:?})", self.value(), self.unit())
    }
}

/// A closed interval of time, for example the interval of a condition's part, by its tag.
#[pyclass(frozen, eq, hash, from_py_object, module = "apex_autonomy")]
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct Interval {
    start: Time,
    end: Time,
}

#[pymethods]
impl Interval {
    /// int: First instant, in nanoseconds.
    #[getter]
    fn start_ns(&self) -> i64 {
        self.start.0
    }

    /// int: Last instant, in nanoseconds.
    #[getter]
    fn end_ns(&self) -> i64 {
        self.end.0
    }

    /// float: First instant, in seconds.
    #[getter]
    fn start_s(&self) -> f64 {
        self.start.seconds()
    }

    /// float: Last instant, in seconds.
    #[getter]
    fn end_s(&self) -> f64 {
        self.end.seconds()
    }

    /// float: Last minus first instant, in seconds.
    #[getter]
    fn duration_s(&self) -> f64 {
        (self.end - self.start).seconds()
    }

    fn __repr__(&self) -> String {
        format!("Interval({} to {})", self.start, self.end)
    }
}

/// A state variable: an attribute and its object.
///
/// Parameters
/// ----------
/// text : str
///     ``"(roll-angle aircraft-1)"``, or an attribute without object, ``"rssi"``.
///
/// Raises
/// ------
/// InputError
///     The text names no state variable.
#[pyclass(frozen, eq, hash, from_py_object, module = "apex_autonomy")]
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct Variable(pub(crate) StateVariable);

#[pymethods]
impl Variable {
    #[new]
    fn new(text: &str) -> PyResult<Variable> {
        let wrong = |why: &str| input(format!("{text:?} is not a state variable: {why}; write (ATTRIBUTE OBJECT)"));
        let value = apex_pdl::read_value(text).map_err(|diagnostic| wrong(&diagnostic.message))?;
        let variable = match &value {
            Value::Symbol(attribute) => Some(StateVariable::new(attribute.clone(), Value::nil())),
            Value::List(items) => match &**items {
                [Value::Symbol(attribute)] => Some(StateVariable::new(attribute.clone(), Value::nil())),
                [Value::Symbol(attribute), object] => Some(StateVariable::new(attribute.clone(), object.clone())),
                [Value::Symbol(attribute), objects @ ..] => {
                    Some(StateVariable::new(attribute.clone(), Value::list(objects.iter().cloned())))
                }
                _ => None,
            },
            _ => None,
        };
        variable.map(Variable).ok_or_else(|| wrong("it does not begin with the name of an attribute"))
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        format!("Variable({:?})", self.0.to_string())
    }
}

/// Converts to Python: numbers, strings and lists unchanged, durations and instants as ``numpy.timedelta64``.
pub(crate) fn to_python<'py>(python: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::Integer(integer) => integer.into_bound_py_any(python),
        Value::Real(real) => real.into_bound_py_any(python),
        Value::Quantity(quantity) => Quantity(*quantity).into_bound_py_any(python),
        Value::Duration(Duration(nanoseconds)) | Value::Time(Time(nanoseconds)) => {
            python.import("numpy")?.getattr("timedelta64")?.call1((*nanoseconds, "ns"))
        }
        Value::Symbol(symbol) => Symbol(symbol.clone()).into_bound_py_any(python),
        Value::Text(text) => text.into_bound_py_any(python),
        Value::List(items) => {
            let items = items.iter().map(|item| to_python(python, item)).collect::<PyResult<Vec<_>>>()?;
            Ok(PyList::new(python, items)?.into_any())
        }
        Value::Interval(start, end) => Interval { start: *start, end: *end }.into_bound_py_any(python),
        Value::Task(_) | Value::Closure(_) => value.to_string().into_bound_py_any(python),
    }
}

/// Maximum depth of nested lists; a list that contains itself is deeper.
const LIST_DEPTH_MAX: usize = 64;
/// Units of NumPy that are finer than a nanosecond: all of their instants are in reach, and conversion drops digits.
const FINER_UNITS: [&str; 3] = ["ps", "fs", "as"];
/// Units of NumPy's durations that have no fixed length: months and years, and no unit.
const UNITS_WITHOUT_LENGTH: [&str; 3] = ["generic", "M", "Y"];

/// Converts a value of Python to a value of PDL.
///
/// # Errors
/// `InputError` if PDL has no corresponding value.
pub(crate) fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    converted(value, 0)
}

fn converted(value: &Bound<'_, PyAny>, depth: usize) -> PyResult<Value> {
    if value.is_none() {
        // A missing measurement.
        return Ok(Value::Real(f64::NAN));
    }
    if let Ok(truth) = value.cast::<PyBool>() {
        return Ok(Value::truth(truth.is_true()));
    }
    if value.cast::<PyInt>().is_ok() {
        return value.extract().map(Value::Integer).map_err(|_| input(format!("{value} is beyond 64 bits")));
    }
    if let Ok(real) = value.cast::<PyFloat>() {
        return Ok(Value::Real(real.value()));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::text(&text.to_cow()?));
    }
    if let Ok(symbol) = value.extract::<Symbol>() {
        return Ok(Value::Symbol(symbol.0));
    }
    if let Ok(quantity) = value.extract::<Quantity>() {
        return Ok(Value::Quantity(quantity.0));
    }
    if value.cast::<PyList>().is_ok() || value.cast::<PyTuple>().is_ok() {
        if depth == LIST_DEPTH_MAX {
            return Err(input(format!("lists are nested deeper than {LIST_DEPTH_MAX}, or a list contains itself")));
        }
        let items = value.try_iter()?.map(|item| converted(&item?, depth + 1)).collect::<PyResult<Vec<_>>>()?;
        return Ok(Value::list(items));
    }
    let name = value.get_type().name()?.to_cow()?.into_owned();
    // A truth value of NumPy is another type than the `bool` of Python.
    if name == "bool" || name == "bool_" {
        return value.is_truthy().map(Value::truth);
    }
    if name == "timedelta64" {
        return nanoseconds_of(value).map(|nanoseconds| Value::Duration(Duration(nanoseconds)));
    }
    if name == "ndarray" {
        return match value.call_method0("item") {
            Ok(item) if value.getattr("ndim")?.extract::<usize>()? == 0 => converted(&item, depth),
            _ => Err(input("an array is not a value: pass its samples to `extend`, or a list".to_string())),
        };
    }
    // Numbers of other libraries, such as NumPy's scalars.
    if value.hasattr("__index__")? {
        let index = value.call_method0("__index__")?;
        return index.extract().map(Value::Integer).map_err(|_| input(format!("{value} is beyond 64 bits")));
    }
    if name != "datetime64" && value.hasattr("__float__")? {
        return value.extract().map(Value::Real).map_err(|error| input(format!("{value} is not a number: {error}")));
    }
    let kind = value.get_type().name()?;
    Err(input(format!(
        "PDL has no value like {value} of type {kind}: hand over a number, str, Symbol, Quantity, bool or list"
    )))
}

/// Returns an instant in whole nanoseconds. It is seconds as a number, or a ``numpy.timedelta64``, ``numpy.datetime64`` or
/// ``datetime.timedelta``.
///
/// # Errors
/// `InputError` if it is none of these, not a time, or further from zero than 292 years.
pub(crate) fn nanoseconds_of(instant: &Bound<'_, PyAny>) -> PyResult<i64> {
    let wrong = |why: &str| input(format!("{instant} is not an instant: {why}"));
    let name = instant.get_type().name()?.to_cow()?.into_owned();
    if name == "timedelta64" || name == "datetime64" {
        let kind = instant.getattr("dtype")?;
        let scale = instant.py().import("numpy")?.call_method1("datetime_data", (&kind,))?.get_item(0)?;
        let scale: String = scale.extract()?;
        if name == "timedelta64" && UNITS_WITHOUT_LENGTH.contains(&scale.as_str()) {
            return Err(wrong("a duration needs a unit of fixed length, for example timedelta64[ms]"));
        }
        let unit = if name == "timedelta64" { "timedelta64[ns]" } else { "datetime64[ns]" };
        let exact = instant.call_method1("astype", (unit,))?;
        let nanoseconds: i64 = exact.call_method1("astype", ("int64",))?.extract()?;
        if nanoseconds == i64::MIN {
            return Err(wrong("not a time"));
        }
        // The conversion wraps around silently.
        let is_kept = exact.call_method1("astype", (&kind,))?.eq(instant)?;
        let is_fine = FINER_UNITS.contains(&scale.as_str());
        return if is_kept || is_fine { Ok(nanoseconds) } else { Err(wrong("too far away")) };
    }
    if name == "timedelta" {
        let [days, seconds, microseconds] = ["days", "seconds", "microseconds"];
        let part = |name: &str| instant.getattr(name)?.extract::<i128>();
        let total = ((part(days)? * 86_400 + part(seconds)?) * 1_000_000 + part(microseconds)?) * 1_000;
        return i64::try_from(total).map_err(|_| wrong("too far away"));
    }
    if let Ok(whole) = instant.extract::<i64>() {
        return whole.checked_mul(NANOSECONDS_PER_SECOND).ok_or_else(|| wrong("too far away"));
    }
    let seconds: f64 = instant.extract().map_err(|_| wrong("seconds as a number, or a numpy.timedelta64"))?;
    let nanoseconds = (seconds * NANOSECONDS_PER_SECOND as f64).round();
    if nanoseconds.is_finite() && nanoseconds.abs() < i64::MAX as f64 {
        Ok(nanoseconds as i64)
    } else {
        Err(wrong(if seconds.is_nan() { "not a number" } else { "too far away" }))
    }
}
