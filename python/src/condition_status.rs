//! Status of a condition, with its reasons.

use apex_executive::Judgement;
use apex_executive::state::monitors::monitor::{Unmet, Verdict};
use pyo3::prelude::*;

/// Status of a condition.
#[pyclass(frozen, module = "apex_autonomy")]
pub(crate) struct ConditionStatus {
    judgement: Judgement,
}

impl ConditionStatus {
    pub(crate) fn new(judgement: Judgement) -> ConditionStatus {
        ConditionStatus { judgement }
    }
}

#[pymethods]
impl ConditionStatus {
    /// str: ``"satisfied"``, ``"not satisfied"`` or ``"unknown"``.
    #[getter]
    fn verdict(&self) -> &'static str {
        match &self.judgement.verdict {
            Verdict::Satisfied(_) => "satisfied",
            Verdict::NotSatisfied => "not satisfied",
            Verdict::Unknown => "unknown",
        }
    }

    /// list of Reason: The parts of the condition that do not hold; empty if it is satisfied.
    #[getter]
    fn because(&self) -> Vec<Reason> {
        self.judgement.because.iter().cloned().map(|unmet| Reason { unmet }).collect()
    }

    /// int: Number of results so far.
    #[getter]
    fn results(&self) -> u64 {
        self.judgement.results
    }

    fn __str__(&self) -> String {
        let reasons: Vec<String> = self.judgement.because.iter().map(sentence).collect();
        match reasons.is_empty() {
            true => self.verdict().to_string(),
            false => format!("{}: {}", self.verdict(), reasons.join("; ")),
        }
    }

    fn __repr__(&self) -> String {
        format!("<ConditionStatus {}>", self.__str__())
    }
}

/// A part of a condition that does not hold, with the present knowledge about it.
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

    /// str: The present knowledge about the part.
    #[getter]
    fn now(&self) -> &str {
        &self.unmet.now
    }

    /// int or None: The instant since which this is so, in nanoseconds.
    #[getter]
    fn since_ns(&self) -> Option<i64> {
        self.unmet.since.map(|since| since.0)
    }

    /// int or None: The instant at which the part becomes true by time alone, if nothing changes before, in nanoseconds.
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
