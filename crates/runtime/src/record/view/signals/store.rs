//! The samples of a record, kept in memory and extended with it.

use super::limits;
use super::sample::StoredSample;
use super::types::{Signal, SignalKind};
use crate::error::RecordError;
use crate::record::reader::RecordReader;
use crate::record::restore::RestoredProgram;
use crate::record::steps::Steps;
use apex_model::event::{EventKind, StateVariable};
use apex_model::quantity::Quantity;
use apex_model::time::Time;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Up to this number of samples all signals are kept; above it, only the requested ones. A sample takes 24 bytes.
const SAMPLES_KEPT_MAX: usize = 6_000_000;

/// The samples of one signal, by time.
#[derive(Debug, Default)]
pub(in crate::record::view) struct Series {
    pub(in crate::record::view) samples: Vec<StoredSample>,
    pub(in crate::record::view) words: Vec<String>,
}

/// A measured state variable.
#[derive(Debug)]
pub(in crate::record::view) struct MeasuredVariable {
    pub(in crate::record::view) number: u64,
    variable: StateVariable,
    kind: SignalKind,
    /// Printing unit, and its size in SI units.
    unit: (&'static str, f64),
    pub(in crate::record::view) first_ns: i64,
}

/// The signals of a record.
#[derive(Default)]
pub(in crate::record::view) struct SampleIndex {
    /// The last step that was read.
    seen_batch: i64,
    /// Variables by number; the numbers are in order of first appearance.
    known: BTreeMap<u64, MeasuredVariable>,
    numbers: BTreeMap<StateVariable, u64>,
    series: BTreeMap<u64, Series>,
    samples: usize,
    /// True if only requested signals are kept, because the record is too large for all.
    choosy: bool,
}

impl MeasuredVariable {
    /// Returns the signal, with its limits if there is a program.
    pub(in crate::record::view) fn signal(&self, program: Option<&RestoredProgram>) -> Signal {
        let limits = match (program, self.kind) {
            (Some(program), SignalKind::Number) => limits::limits_of(&program.0, &self.variable, self.unit.1),
            _ => Vec::new(),
        };
        Signal {
            name: self.variable.to_string(),
            attribute: self.variable.attribute.to_string(),
            object: self.variable.object.to_string(),
            unit: self.unit.0.to_owned(),
            kind: self.kind,
            first_ns: self.first_ns,
            limits,
        }
    }
}

impl SampleIndex {
    /// Returns the measured variables, in order of first appearance.
    pub(in crate::record::view) fn known(&self) -> impl Iterator<Item = &MeasuredVariable> {
        self.known.values()
    }

    /// Returns the variable with this name, in any case.
    pub(in crate::record::view) fn called(&self, name: &str) -> Option<&MeasuredVariable> {
        self.known.values().find(|known| known.variable.to_string().eq_ignore_ascii_case(name))
    }

    pub(in crate::record::view) fn series(&self, number: u64) -> Option<&Series> {
        self.series.get(&number)
    }

    /// Reads the samples added since the last call, and all samples of the signals in `names` that are not kept yet.
    pub(in crate::record::view) fn refresh(
        &mut self,
        reader: &RecordReader,
        names: &[String],
    ) -> Result<(), RecordError> {
        self.read(reader, self.seen_batch + 1, None)?;
        let missing: BTreeSet<u64> = names
            .iter()
            .filter_map(|name| self.called(name).map(|known| known.number))
            .filter(|number| !self.series.contains_key(number))
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        missing.iter().for_each(|number| {
            self.series.insert(*number, Series::default());
        });
        self.read(reader, 1, Some(&missing))
    }

    /// Reads the steps from `first` on: of all variables, or only samples of `again`.
    fn read(&mut self, reader: &RecordReader, first: i64, again: Option<&BTreeSet<u64>>) -> Result<(), RecordError> {
        for step in Steps::new(reader, first, Time::END)?.without_effects() {
            let step = step?;
            for event in step.batch.events {
                let EventKind::Measurement(variable, value) = event.kind else { continue };
                let number = match self.numbers.get(&variable) {
                    Some(number) => *number,
                    None => self.meet(variable, &value, step.batch.now.0),
                };
                if again.is_none_or(|again| again.contains(&number)) {
                    self.keep(number, (event.at.0, step.batch.now.0), &value);
                }
            }
            self.seen_batch = self.seen_batch.max(step.batch_number);
        }
        Ok(())
    }

    /// Returns a variable that was not measured before.
    fn meet(&mut self, variable: StateVariable, value: &Value, first_ns: i64) -> u64 {
        let number = self.known.len() as u64 + 1;
        let kind = match value {
            Value::List(_) if value.is_true() => SignalKind::Other,
            Value::List(_) | Value::Symbol(_) | Value::Text(_) => SignalKind::Words,
            _ if value.as_number().is_some() => SignalKind::Number,
            _ => SignalKind::Other,
        };
        let unit = match (value, value.as_number()) {
            (Value::Duration(_), _) => ("s", 1.0),
            (Value::Quantity(quantity), _) => printing_unit(quantity),
            _ => ("", 1.0),
        };
        self.numbers.insert(variable.clone(), number);
        self.known.insert(number, MeasuredVariable { number, variable, kind, unit, first_ns });
        if !self.choosy && kind != SignalKind::Other {
            self.series.insert(number, Series::default());
        }
        number
    }

    fn keep(&mut self, number: u64, (at_ns, arrived_ns): (i64, i64), value: &Value) {
        let (Some(known), Some(series)) = (self.known.get(&number), self.series.get_mut(&number)) else { return };
        let value = match known.kind {
            SignalKind::Number => value.as_number().map(|(si, _)| si / known.unit.1).filter(|value| value.is_finite()),
            SignalKind::Words => Some(series.word(value.to_string())),
            SignalKind::Other => None,
        };
        // Values of another kind than the first one cannot be drawn on its axis.
        let Some(value) = value else { return };
        let place = match series.samples.last() {
            Some(last) if last.at_ns > at_ns => series.samples.partition_point(|sample| sample.at_ns <= at_ns),
            _ => series.samples.len(),
        };
        series.samples.insert(place, StoredSample { at_ns, arrived_ns, value });
        self.samples += 1;
        if self.samples > SAMPLES_KEPT_MAX && !self.choosy {
            self.choosy = true;
            self.series.clear();
        }
    }
}

impl Series {
    /// Returns the place of a word in the list of words.
    fn word(&mut self, word: String) -> f64 {
        let place = self.words.iter().position(|known| *known == word).unwrap_or_else(|| {
            self.words.push(word);
            self.words.len() - 1
        });
        place as f64
    }
}

fn printing_unit(quantity: &Quantity) -> (&'static str, f64) {
    quantity.unit().map_or(("", 1.0), |unit| (unit.name, unit.factor))
}
