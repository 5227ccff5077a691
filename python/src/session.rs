//! One watched condition.

use crate::condition_status::ConditionStatus;
use crate::errors::{ConditionError, input};
use crate::results::Results;
use crate::source::{Ready, read};
use crate::values::{Variable, from_python, nanoseconds_of};
use apex_executive::MonitorSession;
use apex_executive::state::clause::MonitorId;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// A condition with its samples and messages so far. `apex_autonomy.Monitor` is the public class around it.
#[pyclass(module = "apex_autonomy")]
pub(crate) struct Session {
    session: MonitorSession,
    watch: MonitorId,
    #[pyo3(get)]
    warnings: String,
    /// The state variables that the condition names with their objects.
    #[pyo3(get)]
    variables: Vec<Variable>,
    created_at: Option<Time>,
    /// Attributes that the condition reads; `None` if it may read any.
    read: Option<BTreeSet<Symbol>>,
}

#[pymethods]
impl Session {
    #[new]
    #[pyo3(signature = (condition, *, library=None, folder=None, created_ns=None, gaps=false))]
    fn new(
        condition: &str,
        library: Option<(String, String)>,
        folder: Option<PathBuf>,
        created_ns: Option<i64>,
        gaps: bool,
    ) -> PyResult<Session> {
        let Ready { condition, library, host, warnings } = read(condition, library, folder)?;
        let variables = condition.ground_variables().into_iter().map(Variable).collect();
        let mut session = MonitorSession::new(library, host).map_err(ConditionError::new_err)?;
        if gaps {
            session = session.with_gaps();
        }
        let created_at = created_ns.map(Time);
        let read = session.attributes_read(std::slice::from_ref(&condition));
        let watch = session
            .watch(condition, created_at.unwrap_or(Time::BEGINNING))
            .map_err(|trouble| ConditionError::new_err(trouble.message))?;
        Ok(Session { session, watch, warnings, variables, created_at, read })
    }

    fn sample(&mut self, variable: &Variable, value: &Bound<'_, PyAny>, at: &Bound<'_, PyAny>) -> PyResult<()> {
        let (value, at) = (from_python(value)?, nanoseconds_of(at)?);
        self.session.sample(&variable.0, value, Time(at));
        Ok(())
    }

    fn samples(
        &mut self,
        python: Python<'_>,
        variable: &Variable,
        instants_ns: PyReadonlyArray1<'_, i64>,
        values: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let (instants_ns, values) = (instants_ns.as_array(), values.as_array());
        if instants_ns.len() != values.len() {
            let message = format!("there are {} instants for {} values", instants_ns.len(), values.len());
            return Err(input(message));
        }
        let session = &mut self.session;
        python.detach(|| {
            let instants: Vec<Time> = instants_ns.iter().copied().map(Time).collect();
            match values.as_slice() {
                Some(values) => session.samples(&variable.0, &instants, values),
                None => session.samples(&variable.0, &instants, &values.to_vec()),
            }
        });
        Ok(())
    }

    /// Records values that are not all numbers. All of them are converted before the first is recorded.
    fn items(
        &mut self,
        variable: &Variable,
        instants_ns: PyReadonlyArray1<'_, i64>,
        values: Vec<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let values = values.iter().map(from_python).collect::<PyResult<Vec<Value>>>()?;
        for (at, value) in instants_ns.as_array().iter().zip(values) {
            self.session.sample(&variable.0, value, Time(*at));
        }
        Ok(())
    }

    /// Returns a warning if the condition does not read a variable's attribute.
    fn unread(&self, variable: &Variable) -> Option<String> {
        let read = self.read.as_ref().filter(|read| !read.contains(&variable.0.attribute))?;
        let names: Vec<&str> = read.iter().map(Symbol::folded).collect();
        let names = if names.is_empty() { "no state variable".to_string() } else { names.join(", ") };
        Some(format!("the condition does not read {}, whose samples change nothing; it reads {names}", variable.0))
    }

    fn event(&mut self, form: &Bound<'_, PyAny>, at: &Bound<'_, PyAny>) -> PyResult<()> {
        // A message is parsed as PDL, because as a string it would be a value that matches no pattern.
        let form: Value = match form.extract::<String>() {
            Ok(text) => apex_pdl::read_value(&text).map_err(|diagnostic| {
                input(format!("{text:?} is not a message: {}; write (WORD ..)", diagnostic.message))
            })?,
            Err(_) => from_python(form)?,
        };
        let is_message = match &form {
            Value::List(items) => matches!(items.first(), Some(Value::Symbol(_))),
            other => matches!(other, Value::Symbol(_)),
        };
        if !is_message {
            return Err(input(format!(
                "{form} is not a message: write (WORD ..); in a list the word is a Symbol, Symbol(\"ready\")"
            )));
        }
        self.session.event(form, Time(nanoseconds_of(at)?));
        Ok(())
    }

    fn advance(&mut self, python: Python<'_>, now: &Bound<'_, PyAny>) -> PyResult<()> {
        let now = Time(nanoseconds_of(now)?);
        let session = &mut self.session;
        python.detach(|| session.advance(now));
        Ok(())
    }

    fn finish(&mut self, python: Python<'_>) {
        let session = &mut self.session;
        python.detach(|| session.finish());
    }

    fn take_results(&mut self) -> Results {
        Results::new(self.session.take_results())
    }

    fn take_errors(&mut self) -> Vec<String> {
        self.session
            .take_troubles()
            .into_iter()
            .map(|trouble| format!("at {}: {}", trouble.at, trouble.message))
            .collect()
    }

    fn status(&self) -> PyResult<ConditionStatus> {
        match self.session.verdict(self.watch) {
            Some(told) => Ok(ConditionStatus::new(told)),
            None => Err(ConditionError::new_err("the condition could not be watched; see the errors")),
        }
    }

    /// Returns the numbers of samples of a variable: kept, late, replaced and missing.
    fn counts(&self, variable: &Variable) -> (usize, u64, u64, u64) {
        match self.session.histories().get(&variable.0) {
            Some(history) => {
                (history.samples().len(), history.late_count, history.replaced_count, history.missing_count)
            }
            None => (0, 0, 0, 0),
        }
    }

    #[getter]
    fn now_ns(&self) -> Option<i64> {
        let now = self.session.now();
        (now != Time::BEGINNING).then_some(now.0)
    }

    #[getter]
    fn created_ns(&self) -> Option<i64> {
        self.created_at.map(|created_at| created_at.0)
    }
}
