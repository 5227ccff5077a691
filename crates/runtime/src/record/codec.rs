//! Batches as bytes. A day of telemetry is millions of samples, so a regular sample costs about ten bytes.
//!
//! A batch consists of the number of events, the sequence number of the first, and the events. A regular event has the next sequence
//! number and the batch's instant; others carry both differences. State variables are referred to by number. A quantity with the usual
//! dimension and printing unit of its variable is stored as its number alone. Integers are LEB128 (signed ones zigzag), reals eight bytes
//! little-endian, everything else postcard.

use super::numbers::{Input, put_signed, put_unsigned};
use apex_model::event::{Batch, Event, EventKind, StateVariable};
use apex_model::limits::BATCH_EVENTS_MAX;
use apex_model::quantity::{Dimension, Quantity};
use apex_model::time::Time;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const SAMPLE_USUAL: u8 = 0;
const SAMPLE_REAL: u8 = 1;
const SAMPLE_OTHER: u8 = 2;
const OTHER_EVENT: u8 = 3;
const WOKEN: u8 = 4;
/// Added to the kind if sequence number or time are not the expected ones.
const IRREGULAR: u8 = 0x80;

/// Dimension and printing unit of a quantity.
pub(super) type Shape = (Dimension, Option<u8>);

/// A numbered state variable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Variable {
    pub(super) variable: StateVariable,
    /// The shape of its first sample, if that was a quantity.
    pub(super) usual: Option<Shape>,
}

/// State variables with their numbers, in order of first appearance, from 1.
///
/// Variables whose names differ only in case are one variable for the executive, but two here: replay must receive exactly what was
/// received.
#[derive(Clone, Debug, Default)]
pub(super) struct Variables {
    list: Vec<Variable>,
    numbers: BTreeMap<Vec<u8>, u64>,
    /// For each variable by number, the two variables that followed it last, the latest first. The order of telemetry repeats, and groups
    /// of different rates can alternate two orders.
    successors: Vec<[u64; 2]>,
}

impl Variables {
    pub(super) fn add(&mut self, variable: Variable) -> u64 {
        let number = self.list.len() as u64 + 1;
        self.numbers.insert(spelling(&variable.variable), number);
        self.list.push(variable);
        number
    }

    pub(super) fn get(&self, number: u64) -> Option<&Variable> {
        let index = usize::try_from(number.checked_sub(1)?).ok()?;
        self.list.get(index)
    }

    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// Returns the number of `variable`, which was measured after the variable `before` (0: as the first of a batch).
    fn number_after(&mut self, before: u64, variable: &StateVariable) -> Option<u64> {
        let slot = usize::try_from(before).ok()?;
        let [latest, earlier] = self.successors.get(slot).copied().unwrap_or_default();
        let is = |guess: &u64| self.get(*guess).is_some_and(|known| same_spelling(&known.variable, variable));
        if is(&latest) {
            return Some(latest);
        }
        let number = match Some(earlier).filter(is) {
            Some(earlier) => earlier,
            None => self.numbers.get(&spelling(variable)).copied()?,
        };
        if slot >= self.successors.len() {
            self.successors.resize(self.list.len() + 1, [0; 2]);
        }
        if let Some(successors) = self.successors.get_mut(slot) {
            *successors = [number, latest];
        }
        Some(number)
    }
}

/// Returns a key that keeps the case of letters and the type of numbers.
fn spelling(variable: &StateVariable) -> Vec<u8> {
    postcard::to_stdvec(variable).unwrap_or_else(|_| variable.to_string().into_bytes())
}

fn same_spelling(a: &StateVariable, b: &StateVariable) -> bool {
    a.attribute.printed() == b.attribute.printed()
        && match (&a.object, &b.object) {
            (Value::Symbol(a), Value::Symbol(b)) => a.printed() == b.printed(),
            (Value::Integer(a), Value::Integer(b)) => a == b,
            _ => spelling(a) == spelling(b),
        }
}

/// Writes `batch` into `bytes` (cleared first); adds variables that were not seen before.
pub(super) fn encode(batch: &Batch, variables: &mut Variables, bytes: &mut Vec<u8>) -> Result<(), postcard::Error> {
    bytes.clear();
    put_unsigned(bytes, batch.events.len() as u64);
    let mut expected = batch.events.first().map_or(0, |event| event.sequence);
    put_unsigned(bytes, expected);
    let mut before = 0;
    for event in &batch.events {
        let regular = event.sequence == expected && event.at == batch.now;
        let kind_at = bytes.len();
        bytes.push(if regular { 0 } else { IRREGULAR });
        if !regular {
            put_unsigned(bytes, event.sequence.wrapping_sub(expected));
            put_signed(bytes, batch.now.0.wrapping_sub(event.at.0));
        }
        expected = event.sequence.wrapping_add(1);
        let kind = encode_kind(&event.kind, &mut before, variables, bytes)?;
        if let Some(slot) = bytes.get_mut(kind_at) {
            *slot |= kind;
        }
    }
    Ok(())
}

fn encode_kind(
    kind: &EventKind,
    before: &mut u64,
    variables: &mut Variables,
    bytes: &mut Vec<u8>,
) -> Result<u8, postcard::Error> {
    let (variable, value) = match kind {
        EventKind::Measurement(variable, value) => (variable, value),
        EventKind::Woken => return Ok(WOKEN),
        other => {
            *bytes = postcard::to_extend(other, std::mem::take(bytes))?;
            return Ok(OTHER_EVENT);
        }
    };
    let number = match variables.number_after(*before, variable) {
        Some(number) => number,
        None => variables.add(Variable { variable: variable.clone(), usual: shape(value) }),
    };
    *before = number;
    put_unsigned(bytes, number);
    match value {
        Value::Real(real) => {
            bytes.extend_from_slice(&real.to_le_bytes());
            Ok(SAMPLE_REAL)
        }
        Value::Quantity(quantity) if variables.get(number).is_some_and(|known| known.usual == shape(value)) => {
            bytes.extend_from_slice(&quantity.si.to_le_bytes());
            Ok(SAMPLE_USUAL)
        }
        other => {
            *bytes = postcard::to_extend(other, std::mem::take(bytes))?;
            Ok(SAMPLE_OTHER)
        }
    }
}

fn shape(value: &Value) -> Option<Shape> {
    match value {
        Value::Quantity(quantity) => Some((quantity.dimension, quantity.unit)),
        _ => None,
    }
}

/// Reads a batch of the instant `now` back.
///
/// # Errors
/// The error in the bytes, as a fragment of a message.
pub(super) fn decode(now: Time, bytes: &[u8], variables: &Variables) -> Result<Batch, String> {
    let mut input = Input { bytes };
    let count = input.unsigned()?;
    let count = usize::try_from(count).ok().filter(|count| *count <= BATCH_EVENTS_MAX);
    let count = count.ok_or("it claims more events than a batch may have")?;
    let mut expected = input.unsigned()?;
    let mut events = Vec::with_capacity(count.min(bytes.len()));
    for _ in 0..count {
        let kind = input.byte()?;
        let (mut sequence, mut at) = (expected, now);
        if kind & IRREGULAR != 0 {
            sequence = expected.wrapping_add(input.unsigned()?);
            at = Time(now.0.wrapping_sub(input.signed()?));
        }
        expected = sequence.wrapping_add(1);
        let kind = decode_kind(kind & !IRREGULAR, &mut input, variables)?;
        events.push(Event { sequence, at, kind });
    }
    if !input.bytes.is_empty() {
        return Err("bytes are left over".into());
    }
    Ok(Batch { now, events })
}

fn decode_kind(kind: u8, input: &mut Input<'_>, variables: &Variables) -> Result<EventKind, String> {
    match kind {
        WOKEN => return Ok(EventKind::Woken),
        OTHER_EVENT => return input.postcard(),
        SAMPLE_USUAL | SAMPLE_REAL | SAMPLE_OTHER => {}
        unknown => return Err(format!("event kind {unknown} is not known")),
    }
    let number = input.unsigned()?;
    let known = variables.get(number).ok_or_else(|| format!("state variable number {number} is not known"))?;
    let value = match kind {
        SAMPLE_REAL => Value::Real(input.real()?),
        SAMPLE_OTHER => input.postcard()?,
        _ => {
            let (dimension, unit) = known.usual.ok_or_else(|| format!("{} has no usual unit", known.variable))?;
            Value::Quantity(Quantity { si: input.real()?, dimension, unit })
        }
    };
    Ok(EventKind::Measurement(known.variable.clone(), value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    #[test]
    fn batches_come_back_byte_for_byte_and_are_small() {
        let mut variables = Variables::default();
        let mut bytes = Vec::new();
        for (batch, _) in samples::steps() {
            encode(&batch, &mut variables, &mut bytes).unwrap();
            let back = decode(batch.now, &bytes, &variables).unwrap();
            assert_eq!(postcard::to_stdvec(&back).unwrap(), postcard::to_stdvec(&batch).unwrap());
        }
        let packet = samples::batch(5.0, 100, vec![samples::sample("roll-angle", samples::quantity(1.0, "deg")); 35]);
        encode(&packet, &mut variables, &mut bytes).unwrap();
        assert!(bytes.len() <= 2 + 35 * 10, "{} bytes", bytes.len());
    }

    #[test]
    fn variables_in_any_order_have_the_numbers_of_their_names() {
        let (mut variables, mut bytes) = (Variables::default(), Vec::new());
        let mut generator = ChaCha8Rng::seed_from_u64(2);
        for round in 0..2_000 {
            // Two orders in turn, and any order from time to time. Names that differ in case only are two variables.
            let names = ["roll", "Roll", "pitch", "heading", "speed"];
            let order: Vec<usize> = (0..5)
                .map(|place| match round % 3 {
                    0 => place,
                    1 => 4 - place,
                    _ => (generator.next_u64() % 5) as usize,
                })
                .collect();
            let events = order.iter().map(|index| samples::sample(names[*index], samples::quantity(1.0, "deg")));
            let batch = samples::batch(f64::from(round), 1, events.collect());
            encode(&batch, &mut variables, &mut bytes).unwrap();
            let back = decode(batch.now, &bytes, &variables).unwrap();
            assert_eq!(postcard::to_stdvec(&back).unwrap(), postcard::to_stdvec(&batch).unwrap());
        }
        assert_eq!(variables.len(), 5);
    }

    #[test]
    fn random_bytes_are_refused_without_panic() {
        let mut variables = Variables::default();
        let mut bytes = Vec::new();
        for (batch, _) in samples::steps() {
            encode(&batch, &mut variables, &mut bytes).unwrap();
        }
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..20_000 {
            let noise: Vec<u8> = (0..40)
                .map(|_| {
                    let bits = generator.next_u64();
                    (bits >> 56) as u8 & if bits & (1 << 40) == 0 { 0x07 } else { 0xff }
                })
                .collect();
            let _ = decode(Time::ZERO, &noise, &variables);
        }
        assert_eq!(decode(Time::ZERO, &[], &variables), Err("it is cut off".to_owned()));
        assert!(decode(Time::ZERO, &[0xff; 12], &variables).is_err());
    }
}
