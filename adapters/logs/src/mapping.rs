//! Turning fields of logs into state variables.

use crate::mapping_doubts::{MappedField, WrittenEntry, other_unit, second_field, unit_of_label};
use crate::{Cell, LogInterval, Message, Topic};
use apex_model::event::StateVariable;
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use std::collections::BTreeSet;

/// Conversion of a field into a state variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// `TOPIC.FIELD`, or the column of a table. For the angles of [`Take`] it is the quaternion, with elements `[0]` to `[3]`.
    pub field: String,
    /// The state variable.
    pub variable: StateVariable,
    /// Computation from the field.
    pub take: Take,
    /// Factor by which the number in the log is multiplied.
    pub scale: f64,
    /// Factor that replaces `scale` if the log stores the field as an integer and states no unit for it.
    pub integer_scale: Option<f64>,
    /// Offset added after scaling; the result is in the declared unit of the variable.
    pub offset: f64,
    /// Words that replace numbers, such as the modes of an autopilot.
    pub words: Vec<(f64, Value)>,
    /// A number that means that the value is not known.
    pub missing: Option<f64>,
    /// Factor and dimension of the unit in which the variable is declared, where the mapping leaves the field's unit to the
    /// log.
    pub declared: Option<(f64, Dimension)>,
}

/// Computation from a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Take {
    /// The value itself.
    Value,
    /// The roll angle of a quaternion (w, x, y, z), rad, positive to the right.
    Roll,
    /// The pitch angle of a quaternion, rad, positive above the horizon.
    Pitch,
    /// The heading of a quaternion, rad, from north over east, 0 to 2 pi.
    Heading,
}

/// Conversion of fields into state variables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mapping {
    /// Entries: of several for one variable, that of the topic that comes first in the log applies; of one topic, the first entry.
    pub entries: Vec<Entry>,
    /// Places and units of the entries as written in a file.
    pub written: Vec<WrittenEntry>,
}

/// A sample of a state variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampled {
    /// Index of the mapping entry that the variable comes from.
    pub entry: usize,
    /// Value: a number in the declared unit, a symbol or a text.
    pub value: Value,
    /// Instant by the log's clock.
    pub at: Time,
}

/// A field from which a mapping entry takes its samples.
#[derive(Clone, Copy, Debug)]
struct Source {
    entry: usize,
    field: usize,
    /// Factor of the field's numbers.
    scale: f64,
}

/// Converts messages into samples.
#[derive(Debug)]
pub struct Sampler {
    mapping: Mapping,
    /// For each topic, its number of fields and the entries that use it.
    topics: Vec<(usize, Vec<Source>)>,
    /// Samples made by each entry.
    counts: Vec<u64>,
    /// For each variable, the index of the entry that applies, once the log has had a field of it.
    chosen: Vec<Option<usize>>,
    /// True for entries that give samples; the others only give the times of measurements.
    wanted: Vec<bool>,
    /// First and last instant of measurements by the other entries.
    unwanted: Option<LogInterval>,
    /// Notes about entries that the log contradicts or does not need.
    doubts: Vec<String>,
    /// Entries whose field has had a coordinate that does not exist.
    impossible: BTreeSet<usize>,
}

impl Sampler {
    /// Returns per sampler for a log.
    pub fn new(mapping: Mapping) -> Sampler {
        let (counts, chosen) = (vec![0; mapping.entries.len()], vec![None; mapping.entries.len()]);
        let wanted = vec![true; mapping.entries.len()];
        Sampler {
            mapping,
            topics: Vec::new(),
            counts,
            chosen,
            wanted,
            unwanted: None,
            doubts: Vec::new(),
            impossible: BTreeSet::new(),
        }
    }

    /// Restricts the samples to these attributes.
    pub fn keep_only(&mut self, attributes: &BTreeSet<Symbol>) {
        self.wanted = self.mapping.entries.iter().map(|entry| attributes.contains(&entry.variable.attribute)).collect();
    }

    /// Returns the first and last instant of measurements that give no samples.
    pub fn unwanted(&self) -> Option<LogInterval> {
        self.unwanted
    }

    /// Returns the state variables found so far in fields of the log.
    pub fn variables(&self) -> impl Iterator<Item = &StateVariable> {
        self.chosen.iter().flatten().filter_map(|entry| self.mapping.entries.get(*entry)).map(|entry| &entry.variable)
    }

    /// Returns the wanted state variables that no field of the log has given so far, with the fields that the mapping names for them.
    pub fn absent(&self) -> Vec<(StateVariable, Vec<String>)> {
        let present: BTreeSet<&StateVariable> = self.variables().collect();
        let mut absent: Vec<(StateVariable, Vec<String>)> = Vec::new();
        for (entry, wanted) in self.mapping.entries.iter().zip(&self.wanted) {
            if !wanted || present.contains(&entry.variable) {
                continue;
            }
            match absent.iter_mut().find(|(variable, _)| *variable == entry.variable) {
                Some((_, fields)) => fields.push(entry.field.clone()),
                None => absent.push((entry.variable.clone(), vec![entry.field.clone()])),
            }
        }
        absent
    }

    /// Returns notes about wanted entries of a file that the log contradicts or does not need.
    pub fn doubts(&self) -> &[String] {
        &self.doubts
    }

    /// Returns the mapping.
    pub fn mapping(&self) -> &Mapping {
        &self.mapping
    }

    /// Returns the number of samples of each entry.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// Appends the samples of `message` to `samples`.
    pub fn sample(&mut self, topics: &[Topic], message: &Message, samples: &mut Vec<Sampled>) {
        let Some(topic) = topics.get(message.topic) else { return };
        while self.topics.len() <= message.topic {
            self.topics.push((usize::MAX, Vec::new()));
        }
        let stale = self.topics.get(message.topic).is_some_and(|(fields, _)| *fields != topic.fields.len());
        if stale {
            let found = self.fields_of(topic);
            if let Some(slot) = self.topics.get_mut(message.topic) {
                *slot = (topic.fields.len(), found);
            }
        }
        let wanted = self.topics.get(message.topic).map(|(_, wanted)| wanted.as_slice()).unwrap_or_default();
        for source in wanted {
            let number = source.entry;
            let Some(entry) = self.mapping.entries.get(number) else { continue };
            if self.wanted.get(number) == Some(&false) {
                if message.values.get(source.field).is_some_and(|cell| *cell != Cell::Nothing) {
                    let at = message.at;
                    let (first, last) = self.unwanted.unwrap_or((at, at));
                    self.unwanted = Some((first.min(at), last.max(at)));
                }
                continue;
            }
            if let Some(value) = entry.value(&message.values, source) {
                if let Some(doubt) = entry.impossible(&value, message.at) {
                    // One note for each field: a receiver without a fix repeats such a value.
                    if self.impossible.insert(number) {
                        self.doubts.push(doubt);
                    }
                    continue;
                }
                if let Some(count) = self.counts.get_mut(number) {
                    *count += 1;
                }
                samples.push(Sampled { entry: number, value, at: message.at });
            }
        }
    }

    /// Returns the entries that this topic serves, unless another field serves their variables already.
    fn fields_of(&mut self, topic: &Topic) -> Vec<Source> {
        let mut found = Vec::new();
        for (number, entry) in self.mapping.entries.iter().enumerate() {
            let Some(field) = entry.field_in(topic) else { continue };
            let same = |other: &Entry| other.variable == entry.variable;
            let first = self.mapping.entries.iter().position(same).unwrap_or(number);
            let Some(slot) = self.chosen.get_mut(first) else { continue };
            let used = *slot.get_or_insert(number);
            if used == number {
                found.push(Source { entry: number, field, scale: entry.scale_in(topic, field) });
            }
            let Some(written) = self.mapping.written.get(number).filter(|_| self.wanted.get(number) != Some(&false))
            else {
                continue;
            };
            let declared = entry.declared.map(|(_, dimension)| dimension);
            let mapped = MappedField { field: &entry.field, variable: &entry.variable, declared };
            let doubt = match self.mapping.entries.get(used).filter(|_| used != number) {
                Some(used) => second_field(written, mapped, &used.field),
                None => other_unit(written, mapped, topic.units.get(field).and_then(Option::as_ref)),
            };
            self.doubts.extend(doubt.filter(|doubt| !self.doubts.contains(doubt)));
        }
        found
    }
}

impl Entry {
    /// Returns the index of the entry's field among the fields of `topic`.
    fn field_in(&self, topic: &Topic) -> Option<usize> {
        let wanted = self.field.strip_prefix(&topic.name).and_then(|rest| rest.strip_prefix('.'));
        // The only topic of a table has no separate name.
        let wanted = if topic.name == "csv" { Some(wanted.unwrap_or(&self.field)) } else { wanted }?;
        let wanted = if self.take == Take::Value { wanted.to_string() } else { format!("{wanted}[0]") };
        topic.fields.iter().position(|field| *field == wanted)
    }

    /// Returns the factor of the numbers of a field.
    fn scale_in(&self, topic: &Topic, field: usize) -> f64 {
        let stated = topic.units.get(field).and_then(Option::as_ref);
        if let (Some((factor, dimension)), Some(stated)) = (self.declared, stated)
            && let Some(unit) = unit_of_label(&stated.label).filter(|unit| unit.dimension == dimension)
        {
            return self.scale * stated.multiplier * unit.factor / factor;
        }
        let whole = topic.integers.get(field).copied().unwrap_or(false) && stated.is_none();
        self.integer_scale.filter(|_| whole).unwrap_or(self.scale)
    }

    fn value(&self, values: &[Cell], source: &Source) -> Option<Value> {
        let field = source.field;
        let number = match (self.take, values.get(field)?) {
            (Take::Value, Cell::Text(text)) => return Some(self.word_for(text)),
            (Take::Value, Cell::Number(number)) => *number,
            (_, Cell::Number(w)) => {
                let part = |index: usize| match values.get(field + index) {
                    Some(Cell::Number(number)) => Some(*number),
                    _ => None,
                };
                angle(self.take, [*w, part(1)?, part(2)?, part(3)?])
            }
            (_, Cell::Nothing | Cell::Text(_)) => return None,
        };
        if self.missing == Some(number) {
            return None;
        }
        if let Some((_, word)) = self.words.iter().find(|(known, _)| *known == number) {
            return Some(word.clone());
        }
        Some(Value::Real(number * source.scale + self.offset))
    }

    /// Returns a note about a number that no latitude or longitude has: it is not a sample.
    fn impossible(&self, value: &Value, at: Time) -> Option<String> {
        let limit_deg = match self.variable.attribute.folded() {
            "latitude" => 90.0,
            "longitude" => 360.0,
            _ => return None,
        };
        let Value::Real(angle) = value else { return None };
        // Library `vehicle` declares them in degrees; of another unit only the factor to SI is known.
        let angle_deg = match self.declared {
            Some((factor, Dimension::ANGLE)) => (angle * factor).to_degrees(),
            _ => *angle,
        };
        let is_possible = angle_deg.abs() <= limit_deg + 1e-9;
        (!is_possible).then(|| {
            format!(
                "`{}` is {} deg at {at}, which is not a {}: such values of the field are left out",
                self.field,
                (angle_deg * 1e7).round() / 1e7,
                self.variable.attribute
            )
        })
    }

    /// Returns a text of the log as a value: a symbol if it is one word, so that conditions can name it.
    fn word_for(&self, text: &str) -> Value {
        let one_word =
            !text.is_empty() && text.chars().all(|letter| letter.is_ascii_alphanumeric() || "-_".contains(letter));
        if one_word { Value::symbol(&text.to_ascii_lowercase().replace('_', "-")) } else { Value::text(text) }
    }
}

fn angle(take: Take, [w, x, y, z]: [f64; 4]) -> f64 {
    match take {
        Take::Value => w,
        Take::Roll => libm::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        Take::Pitch => libm::asin((2.0 * (w * y - z * x)).clamp(-1.0, 1.0)),
        Take::Heading => {
            let heading = libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
            if heading < 0.0 { heading + std::f64::consts::TAU } else { heading }
        }
    }
}
