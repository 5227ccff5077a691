//! Results of conditions: one by one as objects, or all at once as columns.

use crate::errors::value;
use crate::values::to_python;
use apex_executive::{MonitorResult, ResultEvent};
use apex_model::because;
use apex_model::time::Time;
use numpy::IntoPyArray;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// The results of one call, in order of recognition. A sequence of :class:`Result`; entries are copied only on access.
#[pyclass(frozen, sequence, module = "apex_autonomy")]
pub(crate) struct Results {
    results: Arc<[MonitorResult]>,
}

impl Results {
    pub(crate) fn new(results: Vec<MonitorResult>) -> Results {
        Results { results: results.into() }
    }

    fn instants(&self, pick: impl Fn(&MonitorResult) -> Time) -> Vec<i64> {
        self.results.iter().map(|result| pick(result).0).collect()
    }
}

#[pymethods]
impl Results {
    fn __len__(&self) -> usize {
        self.results.len()
    }

    fn __getitem__(&self, index: isize) -> PyResult<Result> {
        let place = if index < 0 { self.results.len().checked_add_signed(index) } else { usize::try_from(index).ok() };
        match place.filter(|place| *place < self.results.len()) {
            Some(place) => Ok(Result { results: Arc::clone(&self.results), place }),
            None => Err(PyIndexError::new_err(format!("there are {} results", self.results.len()))),
        }
    }

    /// One column as an array.
    ///
    /// Parameters
    /// ----------
    /// name : {"start_ns", "end_ns", "recognised_at_ns", "open", "closed"}
    ///     The column; instants are int64 nanoseconds, the others bool.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray
    ///     One entry for each result.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     There is no such column.
    fn column<'py>(&self, python: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let flags = |pick: fn(&ResultEvent) -> bool| -> Vec<bool> {
            self.results.iter().map(|result| pick(&result.telling)).collect()
        };
        Ok(match name {
            "start_ns" => self.instants(|result| result.result.interval.0).into_pyarray(python).into_any(),
            "end_ns" => self.instants(|result| result.result.interval.1).into_pyarray(python).into_any(),
            "recognised_at_ns" => self.instants(|result| result.result.recognised_at).into_pyarray(python).into_any(),
            "open" => flags(is_open).into_pyarray(python).into_any(),
            "closed" => flags(is_closed).into_pyarray(python).into_any(),
            _ => return Err(value(format!("there is no column {name:?}"))),
        })
    }

    /// Returns the texts of all results, as `str`.
    ///
    /// Returns
    /// -------
    /// list of str
    ///     The evidence of each result as text.
    fn texts(&self) -> Vec<String> {
        self.results.iter().map(words).collect()
    }

    fn __repr__(&self) -> String {
        match self.results.len() {
            1 => "<1 result>".to_string(),
            count => format!("<{count} results>"),
        }
    }
}

/// One way in which a condition became true.
#[pyclass(frozen, module = "apex_autonomy")]
pub(crate) struct Result {
    results: Arc<[MonitorResult]>,
    place: usize,
}

impl Result {
    fn told(&self) -> PyResult<&MonitorResult> {
        self.results.get(self.place).ok_or_else(|| PyIndexError::new_err("no such result"))
    }

    fn instant(&self, pick: impl Fn(&MonitorResult) -> Time) -> PyResult<Time> {
        self.told().map(pick)
    }
}

#[pymethods]
impl Result {
    /// int: Instant of the first evidence, in nanoseconds.
    #[getter]
    fn start_ns(&self) -> PyResult<i64> {
        Ok(self.instant(|told| told.result.interval.0)?.0)
    }

    /// int: Instant of the last evidence, in nanoseconds.
    #[getter]
    fn end_ns(&self) -> PyResult<i64> {
        Ok(self.instant(|told| told.result.interval.1)?.0)
    }

    /// int: Instant at which the result was recognised, in nanoseconds.
    #[getter]
    fn recognised_at_ns(&self) -> PyResult<i64> {
        Ok(self.instant(|told| told.result.recognised_at)?.0)
    }

    /// float: Instant of the first evidence, in seconds.
    #[getter]
    fn start_s(&self) -> PyResult<f64> {
        Ok(self.instant(|told| told.result.interval.0)?.seconds())
    }

    /// float: Instant of the last evidence, in seconds.
    #[getter]
    fn end_s(&self) -> PyResult<f64> {
        Ok(self.instant(|told| told.result.interval.1)?.seconds())
    }

    /// float: Instant at which the result was recognised, in seconds.
    #[getter]
    fn recognised_at_s(&self) -> PyResult<f64> {
        Ok(self.instant(|told| told.result.recognised_at)?.seconds())
    }

    /// bool: The interval may still grow; the result is then returned once more when it is final.
    #[getter]
    fn open(&self) -> PyResult<bool> {
        Ok(is_open(&self.told()?.telling))
    }

    /// bool: The interval is final, and the result was returned before while it was open.
    #[getter]
    fn closed(&self) -> PyResult<bool> {
        Ok(is_closed(&self.told()?.telling))
    }

    /// float or None: The largest time between samples within the runs that the result is based on, in seconds; None without
    /// ``gaps=True``, and if no run has more than one sample that arrived in order.
    #[getter]
    fn gap_s_max(&self) -> PyResult<Option<f64>> {
        let gaps = self.told()?.gaps.iter().map(|gap| (gap.end - gap.start).seconds());
        Ok(gaps.max_by(f64::total_cmp))
    }

    /// dict: Values of the condition's variables and tags, by name without ``?``.
    #[getter]
    fn bindings<'py>(&self, python: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let bindings = PyDict::new(python);
        for (name, bound) in self.told()?.result.bindings.iter() {
            bindings.set_item(name.to_string(), to_python(python, bound)?)?;
        }
        Ok(bindings)
    }

    /// list of Evidence: The facts that the result is based on.
    #[getter]
    fn evidence(&self) -> PyResult<Vec<Evidence>> {
        Ok(self.told()?.result.evidence.iter().cloned().map(|fact| Evidence { fact }).collect())
    }

    fn __str__(&self) -> PyResult<String> {
        self.told().map(words)
    }

    fn __repr__(&self) -> PyResult<String> {
        let result = &self.told()?.result;
        let (start, end) = result.interval;
        Ok(format!("<Result {start} to {end}, recognised at {}>", result.recognised_at))
    }
}

/// A fact that a result is based on; ``str()`` gives it as text.
#[pyclass(frozen, module = "apex_autonomy")]
pub(crate) struct Evidence {
    fact: because::Evidence,
}

#[pymethods]
impl Evidence {
    /// str: ``"sample"``, ``"run"``, ``"event"``, ``"estimate"``, ``"aggregate"``, ``"instant"``, ``"absence"``,
    /// ``"task-state"`` or ``"task-end"``.
    #[getter]
    fn kind(&self) -> &'static str {
        match &self.fact {
            because::Evidence::Sample { .. } => "sample",
            because::Evidence::Event { .. } => "event",
            because::Evidence::TaskState { .. } => "task-state",
            because::Evidence::TaskEnd { .. } => "task-end",
            because::Evidence::Run { .. } => "run",
            because::Evidence::Instant { .. } => "instant",
            because::Evidence::Absence { .. } => "absence",
            because::Evidence::Function { .. } => "function",
            because::Evidence::Estimate(_) => "estimate",
            because::Evidence::Aggregate(_) => "aggregate",
        }
    }

    /// str or None: The state variable, if the fact is about one.
    #[getter]
    fn variable(&self) -> Option<String> {
        match &self.fact {
            because::Evidence::Sample { variable, .. } | because::Evidence::Run { variable, .. } => {
                Some(variable.to_string())
            }
            because::Evidence::Estimate(estimate) => Some(estimate.variable.to_string()),
            because::Evidence::Aggregate(aggregate) => Some(aggregate.variable.to_string()),
            _ => None,
        }
    }

    /// object: The value measured, estimated or computed, the form of an event; None for other kinds.
    #[getter]
    fn value<'py>(&self, python: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        match &self.fact {
            because::Evidence::Sample { value, .. }
            | because::Evidence::Function { value, .. }
            | because::Evidence::Event { form: value, .. } => to_python(python, value).map(Some),
            because::Evidence::Estimate(estimate) => to_python(python, &estimate.value).map(Some),
            because::Evidence::Aggregate(aggregate) => to_python(python, &aggregate.value).map(Some),
            _ => Ok(None),
        }
    }

    /// int or None: Number of samples that the fact is based on; None if it is not about samples.
    #[getter]
    fn samples(&self) -> Option<u64> {
        match &self.fact {
            because::Evidence::Sample { .. } => Some(1),
            because::Evidence::Run { samples, .. } => Some(*samples),
            because::Evidence::Estimate(estimate) => Some(estimate.samples),
            because::Evidence::Aggregate(aggregate) => Some(aggregate.samples),
            _ => None,
        }
    }

    /// int: First instant of the fact, in nanoseconds.
    #[getter]
    fn start_ns(&self) -> i64 {
        span(&self.fact).0.0
    }

    /// int: Last instant of the fact, in nanoseconds.
    #[getter]
    fn end_ns(&self) -> i64 {
        span(&self.fact).1.0
    }

    /// str or None: The estimator, by its name in PDL, if one was used.
    #[getter]
    fn estimator(&self) -> Option<String> {
        match &self.fact {
            because::Evidence::Estimate(estimate) => Some(estimate.estimator.to_string()),
            _ => None,
        }
    }

    fn __str__(&self) -> String {
        self.fact.text()
    }

    fn __repr__(&self) -> String {
        format!("<Evidence {}>", self.fact.text())
    }
}

fn span(fact: &because::Evidence) -> (Time, Time) {
    match fact {
        because::Evidence::Sample { at, .. }
        | because::Evidence::Event { at, .. }
        | because::Evidence::TaskState { at, .. }
        | because::Evidence::TaskEnd { at, .. }
        | because::Evidence::Function { at, .. }
        | because::Evidence::Absence { at, .. } => (*at, *at),
        because::Evidence::Instant { since, at } => (since.unwrap_or(*at), *at),
        because::Evidence::Run { start, end, .. } => (*start, *end),
        because::Evidence::Estimate(estimate) => (estimate.at, estimate.at),
        because::Evidence::Aggregate(aggregate) => aggregate.interval,
    }
}

fn is_open(telling: &ResultEvent) -> bool {
    *telling == ResultEvent::Recognised { open: true }
}

fn is_closed(telling: &ResultEvent) -> bool {
    *telling == ResultEvent::Closed
}

fn words(told: &MonitorResult) -> String {
    let facts: Vec<String> = told.result.evidence.iter().map(because::Evidence::text).collect();
    facts.join(", ")
}
