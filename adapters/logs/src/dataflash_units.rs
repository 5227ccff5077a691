//! Formats of a DataFlash log by name and number, with units from `UNIT`, `MULT` and `FMTU` rows, and one topic for each
//! instance of a sensor (ArduPilot developer documentation, "Logging").

use crate::dataflash::Format;
use crate::{Cell, FieldUnit, TOPICS_MAX, Topic};
use std::collections::BTreeMap;

/// Unit of the field that numbers the instances of a message.
const INSTANCE: char = '#';
/// Unit letters for "no unit" and "unknown unit".
const NO_UNIT: [char; 2] = ['-', '?'];
/// Format letters whose values are scaled by the format itself.
const SCALED: &str = "cCeEL";
/// Format letters of integers.
const WHOLE: &str = "bBhHiIqQ";

/// Format of one kind of message, with the topics of its instances.
struct Definition {
    format: Format,
    /// Field that holds the number of the instance.
    instance_field: Option<usize>,
    /// Topics of the instances other than 0.
    instances: BTreeMap<i64, usize>,
}

/// The formats, units and topics of a log.
#[derive(Default)]
pub(crate) struct FormatTable {
    definitions: BTreeMap<u8, Definition>,
    numbers: BTreeMap<String, u8>,
    labels: BTreeMap<char, String>,
    multipliers: BTreeMap<char, f64>,
    /// Units and multipliers of each kind of message, a letter for each field; they may come before its format.
    stated: BTreeMap<u8, (String, String)>,
    pub(crate) topics: Vec<Topic>,
}

impl FormatTable {
    /// Returns the format of messages of type `kind`.
    pub(crate) fn of_kind(&self, kind: u8) -> Option<&Format> {
        self.definitions.get(&kind).map(|definition| &definition.format)
    }

    /// Returns the type and the format of messages called `name`.
    pub(crate) fn of_name(&self, name: &str) -> Option<(u8, &Format)> {
        let kind = *self.numbers.get(name)?;
        Some((kind, self.of_kind(kind)?))
    }

    /// Adds the definition of an `FMT` row. Returns false if the log defines too many kinds of messages.
    pub(crate) fn define(&mut self, kind: u8, name: &str, length: usize, letters: &str, columns: &[String]) -> bool {
        let known = self.definitions.get(&kind).map(|known| known.format.topic);
        let known = known.or_else(|| self.of_name(name).map(|(_, format)| format.topic));
        if known.is_none() && self.topics.len() >= TOPICS_MAX {
            return false;
        }
        let (format, topic) = Format::new(known.unwrap_or(self.topics.len()), name, length, letters, columns);
        match known.and_then(|known| self.topics.get_mut(known)) {
            Some(slot) => *slot = topic,
            None => self.topics.push(topic),
        }
        self.definitions.insert(kind, Definition { format, instance_field: None, instances: BTreeMap::new() });
        self.numbers.insert(name.to_string(), kind);
        self.apply(kind);
        true
    }

    /// Records units, multipliers or assignments of units if `topic` is `UNIT`, `MULT` or `FMTU`; ignores other rows.
    pub(crate) fn note(&mut self, topic: usize, values: &[Cell]) {
        let name = self.topics.get(topic).map(|topic| topic.name.as_str()).unwrap_or_default();
        let number = |index: usize| match values.get(index) {
            Some(Cell::Number(number)) => Some(*number),
            _ => None,
        };
        let text = |index: usize| match values.get(index) {
            Some(Cell::Text(text)) => text.clone(),
            // In a text log, a row of multipliers that are all digits is read as a number.
            Some(Cell::Number(number)) => number.to_string(),
            _ => String::new(),
        };
        let letter = |index: usize| number(index).map(|code| char::from(code as u8));
        match name {
            "UNIT" => self.labels.extend(letter(1).map(|id| (id, text(2)))),
            "MULT" => self.multipliers.extend(letter(1).zip(number(2)).map(|(id, number)| (id, shortest(number)))),
            "FMTU" => {
                let Some(kind) = number(1).map(|kind| kind as u8) else { return };
                self.stated.insert(kind, (text(2), text(3)));
                self.apply(kind);
                return;
            }
            _ => return,
        }
        let stated: Vec<u8> = self.stated.keys().copied().collect();
        stated.into_iter().for_each(|kind| self.apply(kind));
    }

    /// Applies the known units and multipliers to the format of one kind of message.
    fn apply(&mut self, kind: u8) {
        let Some(definition) = self.definitions.get_mut(&kind) else { return };
        let letters = &definition.format.letters;
        let Some(topic) = self.topics.get_mut(definition.format.topic) else { return };
        topic.integers = letters.iter().map(|letter| WHOLE.contains(*letter)).collect();
        let Some((units, multipliers)) = self.stated.get(&kind) else { return };
        definition.instance_field = units.chars().position(|unit| unit == INSTANCE);
        let mut multiplier_of = multipliers.chars();
        let mut stated = Vec::with_capacity(letters.len());
        for (unit, letter) in units.chars().zip(letters) {
            let multiplier = multiplier_of.next().filter(|_| !SCALED.contains(*letter));
            let multiplier = multiplier.filter(|id| !NO_UNIT.contains(id)).and_then(|id| self.multipliers.get(&id));
            let label = self.labels.get(&unit).filter(|_| unit != INSTANCE && !NO_UNIT.contains(&unit));
            stated.push(label.map(|label| FieldUnit {
                label: label.clone(),
                multiplier: multiplier.copied().filter(|number| *number != 0.0).unwrap_or(1.0),
            }));
        }
        topic.units = stated;
    }

    /// Returns the topic of a message. Each instance other than 0 has its own topic, for example `BARO#1`.
    pub(crate) fn topic_of(&mut self, kind: u8, values: &[Cell]) -> usize {
        let Some(definition) = self.definitions.get_mut(&kind) else { return 0 };
        let whole = definition.format.topic;
        let instance = match definition.instance_field.and_then(|field| values.get(field)) {
            Some(Cell::Number(number)) if *number > 0.0 => *number as i64,
            _ => return whole,
        };
        if let Some(known) = definition.instances.get(&instance) {
            return *known;
        }
        if self.topics.len() >= TOPICS_MAX {
            return whole;
        }
        let Some(topic) = self.topics.get(whole) else { return whole };
        let topic = Topic { name: format!("{}#{instance}", topic.name), ..topic.clone() };
        let number = self.topics.len();
        definition.instances.insert(instance, number);
        self.topics.push(topic);
        number
    }
}

/// Returns the shortest decimal number that equals the multiplier in single precision: logs store 0.1 as 0.10000000149.
fn shortest(number: f64) -> f64 {
    format!("{number:.6e}").parse().unwrap_or(number)
}
