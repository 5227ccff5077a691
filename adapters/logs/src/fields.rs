//! Contents of a log: fields with counts, rates and ranges.

use crate::{Cell, FieldUnit, LogReader, Message};
use apex_model::time::Time;
use std::io;

/// One field over a whole log.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldSummary {
    /// `TOPIC.FIELD`.
    pub name: String,
    /// Number of values.
    pub count: u64,
    /// Messages of its topic per second.
    pub rate_per_s: Option<f64>,
    /// The least and greatest number, if the field has numbers.
    pub range: Option<(f64, f64)>,
    /// The first text, if the field has texts.
    pub text: Option<String>,
    /// The unit stated in the log, with its multiplier unless that is one: `0.001 Gauss`.
    pub unit: Option<String>,
}

/// First and last instant.
pub type LogInterval = (Time, Time);

/// Messages of a topic, their span, and their fields.
type SeenTopic = (u64, Option<LogInterval>, Vec<FieldValues>);

/// Reads a log to its end. Returns the fields in the order of their appearance, and the first and last instant; `None` if the log is empty.
///
/// # Errors
/// The log cannot be read from its medium.
pub fn survey(reader: &mut dyn LogReader) -> io::Result<(Vec<FieldSummary>, Option<LogInterval>)> {
    let mut found: Vec<SeenTopic> = Vec::new();
    let mut span: Option<LogInterval> = None;
    let mut message = Message::default();
    while reader.next(&mut message)? {
        let at = message.at;
        let wider = |span: Option<LogInterval>| Some(span.map_or((at, at), |(from, to)| (from.min(at), to.max(at))));
        span = wider(span);
        if found.len() <= message.topic {
            found.resize(message.topic + 1, Default::default());
        }
        let Some((messages, own_span, fields)) = found.get_mut(message.topic) else { continue };
        *messages += 1;
        *own_span = wider(*own_span);
        if fields.len() < message.values.len() {
            fields.resize(message.values.len(), FieldValues::default());
        }
        fields.iter_mut().zip(&message.values).for_each(|(seen, cell)| seen.add(cell));
    }
    let mut summaries = Vec::new();
    for (topic, (messages, own_span, fields)) in reader.topics().iter().zip(found) {
        let seconds = own_span.map_or(0.0, |(from, to)| (to - from).seconds());
        let rate_per_s = (seconds > 0.0 && messages > 1).then(|| (messages - 1) as f64 / seconds);
        let whole = FieldValues { count: messages, ..FieldValues::default() };
        if topic.fields.is_empty() {
            summaries.push(whole.summary(topic.name.clone(), rate_per_s));
        }
        for (index, (name, seen)) in topic.fields.iter().zip(fields).enumerate() {
            let unit = topic.units.get(index).and_then(Option::as_ref).map(FieldUnit::text);
            summaries.push(FieldSummary { unit, ..seen.summary(format!("{}.{name}", topic.name), rate_per_s) });
        }
    }
    Ok((summaries, span))
}

impl FieldUnit {
    fn text(&self) -> String {
        if self.multiplier == 1.0 { self.label.clone() } else { format!("{} {}", self.multiplier, self.label) }
    }
}

#[derive(Clone, Debug, Default)]
struct FieldValues {
    count: u64,
    range: Option<(f64, f64)>,
    text: Option<String>,
}

impl FieldValues {
    fn add(&mut self, cell: &Cell) {
        match cell {
            Cell::Nothing => return,
            Cell::Number(number) if number.is_nan() => {}
            Cell::Number(number) => {
                self.range = Some(
                    self.range.map_or((*number, *number), |(least, most)| (least.min(*number), most.max(*number))),
                );
            }
            Cell::Text(text) => {
                self.text.get_or_insert_with(|| text.clone());
            }
        }
        self.count += 1;
    }

    fn summary(self, name: String, rate_per_s: Option<f64>) -> FieldSummary {
        let FieldValues { count, range, text } = self;
        FieldSummary { name, count, rate_per_s, range, text, unit: None }
    }
}
