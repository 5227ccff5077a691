//! Queries about signals: which were measured by an instant, and their samples in a window of time.

use super::RecordView;
use super::signals::{PIXELS_DEFAULT, PIXELS_MAX, Raised, SIGNALS_MAX, SignalQuery, SignalWindows, Signals};
use crate::error::RecordError;
use crate::record::restore::RestoredProgram;
use std::sync::PoisonError;

impl RecordView {
    /// Returns the signals that were measured by mission time `at_ns` (nanoseconds; none means the record's end). `program` adds
    /// the limits.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn signals(&mut self, at_ns: Option<i64>, program: Option<&RestoredProgram>) -> Result<Signals, RecordError> {
        self.reader.check_growth()?;
        let mut index = self.indexes.samples.lock().unwrap_or_else(PoisonError::into_inner);
        index.refresh(&self.reader, &[])?;
        let until = at_ns.unwrap_or(i64::MAX);
        let known = index.known().filter(|known| known.first_ns <= until);
        Ok(Signals { signals: known.map(|known| known.signal(program)).collect() })
    }

    /// Returns the windows of the requested signals.
    ///
    /// # Errors
    /// [`RecordError::Damaged`]; [`RecordError::Question`] for more than [`SIGNALS_MAX`] names and for names that the
    /// record does not have.
    pub fn signal_windows(
        &mut self,
        query: &SignalQuery,
        program: Option<&RestoredProgram>,
    ) -> Result<SignalWindows, RecordError> {
        if query.names.len() > SIGNALS_MAX {
            return Err(RecordError::Question(format!(
                "{} signals are requested at once; request at most {SIGNALS_MAX}",
                query.names.len()
            )));
        }
        let at_ns = query.at_ns.unwrap_or(self.growth()?.end_ns);
        let from_ns = query.from_ns.unwrap_or(self.first_ns()?);
        let to_ns = query.to_ns.unwrap_or(at_ns).max(from_ns);
        self.reader.check_growth()?;
        let mut index = self.indexes.samples.lock().unwrap_or_else(PoisonError::into_inner);
        index.refresh(&self.reader, &query.names)?;
        let pixels = query.pixels.unwrap_or(PIXELS_DEFAULT).clamp(1, PIXELS_MAX);
        let mut windows = Vec::with_capacity(query.names.len());
        for name in &query.names {
            let known = index.called(name).ok_or_else(|| {
                RecordError::Question(format!("no state variable `{name}` was measured in this record"))
            })?;
            let Some(series) = index.series(known.number).filter(|_| known.first_ns <= at_ns) else { continue };
            let signal = known.signal(program);
            let raised = Raised::read(&self.reader, &signal.limits, at_ns)?;
            windows.push(series.window(signal, (from_ns, to_ns), at_ns, pixels, &raised));
        }
        Ok(SignalWindows { from_ns, to_ns, at_ns, windows })
    }
}
