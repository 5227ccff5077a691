//! Status of a condition with its reasons.

use apex_executive::Judgement as Told;
use apex_executive::state::monitors::monitor::{Unmet, Verdict};
use pyo3::prelude::*;

/// Status of a condition.
#[pyclass(frozen, module = "apex_autonomy")]
pub(crate) struct Judgement {
    told: Told,
}

impl Judgement {
    pub(crate) fn new(told: Told) -> Judgement {
        Judgement { told }
    }
}

#[pymethods]
impl Judgement {
    /// str: ``"satisfied"``, ``"not satisfied"`` or ``"unknown"``.
    #[getter]
    fn verdict(&self) -> &'static str {
        match &self.told.verdict {
            Verdict::Satisfied(_) => "satisfied",
            Verdict::NotSatisfied => "not satisfied",
            Verdict::Unknown => "unknown",
        }
    }

    /// list of Reason: The parts of the condition that do not hold; empty when it is satisfied.
    #[getter]
    fn because(&self) -> Vec<Reason> {
        self.told.because.iter().cloned().map(|unmet| Reason { unmet }).collect()
    }

    /// int: How many results there were so far.
    #[getter]
    fn results(&self) -> u64 {
        self.told.results
    }

    fn __str__(&self) -> String {
        let reasons: Vec<String> = self.told.because.iter().map(sentence).collect();
        match reasons.is_empty() {
            true => self.verdict().to_string(),
            false => format!("{}: {}", self.verdict(), reasons.join("; ")),
        }
    }

    fn __repr__(&self) -> String {
        format!("<Judgement {}>", self.__str__())
    }
}

/// A part of a condition that does not hold, and what is known about it.
#[pyclass(frozen, module = "apex_autonomy")]
pub(crate) struct Reason {
    unmet: Unmet,
}

#[pymethods]
impl Reason {
    /// str: The part, as PDL.
    #[getter]
    fn what(&self) -> &str {
        &self.unmet.what
    }

    /// str: What is known about it now.
    #[getter]
    fn now(&self) -> &str {
        &self.unmet.now
    }

    /// int or None: Since when that is so, in nanoseconds.
    #[getter]
    fn since_ns(&self) -> Option<i64> {
        self.unmet.since.map(|since| since.0)
    }

    /// int or None: When it comes true by time alone, if nothing changes before, in nanoseconds.
    #[getter]
    fn until_ns(&self) -> Option<i64> {
        self.unmet.until.map(|until| until.0)
    }

    fn __str__(&self) -> String {
        sentence(&self.unmet)
    }

    fn __repr__(&self) -> String {
        format!("<Reason {}>", sentence(&self.unmet))
    }
}

fn sentence(unmet: &Unmet) -> String {
    format!("{}: {}", unmet.what, unmet.now)
}
