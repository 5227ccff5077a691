//! Reader of the record for chains of causes: decisions, samples, and the lines of the program.

use crate::error::RecordError;
use crate::record::view::decisions::Decisions;
use apex_model::event::StateVariable;
use apex_model::source::SourceFile;
use apex_model::time::{Duration, Time};

/// The record up to an instant.
pub(super) struct Log<'a> {
    pub(super) decisions: Decisions<'a>,
    /// The texts that places point into.
    pub(super) sources: Vec<SourceFile>,
}

impl Log<'_> {
    /// Returns the largest time between two of the `samples` of a run, as recorded when the run was recognised. `None` for a single
    /// sample, and if the recorded instants differ from those of the run, because some samples arrived too late or were not numbers.
    pub(super) fn largest_gap(
        &self,
        variable: &StateVariable,
        run: (Time, Time),
        samples: u64,
        known_at: Time,
    ) -> Result<Option<Duration>, RecordError> {
        let found = self.decisions.reader.samples_arrived(variable, run, known_at)?;
        let mut instants: Vec<Time> = found.iter().map(|sample| sample.at).collect();
        instants.sort_unstable();
        instants.dedup();
        let all = u64::try_from(instants.len()).is_ok_and(|found| found == samples);
        let spacings = instants.iter().zip(instants.iter().skip(1)).map(|(before, after)| *after - *before);
        Ok(spacings.max().filter(|_| all))
    }

    /// Returns the line of the program at `file:line:column`.
    pub(super) fn source_line(&self, place: &str) -> Option<String> {
        let (rest, _) = place.rsplit_once(':')?;
        let (file, line) = rest.rsplit_once(':')?;
        let number: usize = line.parse().ok()?;
        let source = self.sources.iter().find(|source| &*source.name == file)?;
        let text = source.text.lines().nth(number.checked_sub(1)?)?.trim();
        (!text.is_empty()).then(|| text.to_owned())
    }
}
