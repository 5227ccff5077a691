//! Tests of effects as bytes: postcard is the naive twin.

use super::decoder::Dictionary;
use super::kind::EffectKind;
use super::splitter::Parts;
use super::{EffectEncoder, EffectReader};
use crate::effect_describer::EffectDescriber;
use crate::samples;
use apex_model::because::{Because, Cause};
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rusqlite::types::ValueRef;

/// A record's effects as bytes, with the words and shapes that a reader has.
#[derive(Default)]
struct Written {
    encoder: EffectEncoder,
    dictionary: Dictionary,
    bytes: Vec<u8>,
}

impl Written {
    fn write(&mut self, now: Time, effects: &[Effect]) {
        self.encoder.encode(now, effects, &mut self.bytes).unwrap();
        let dictionary = &mut self.dictionary;
        let added = self.encoder.new_rows(|_, cells| match cells {
            [_, ValueRef::Text(word)] => {
                dictionary.add_word(std::str::from_utf8(word).unwrap());
                Ok(())
            }
            [_, ValueRef::Blob(layout), ValueRef::Blob(example)] => dictionary.add_shape(layout.to_vec(), example),
            other => Err(format!("{other:?}")),
        });
        added.unwrap();
    }

    fn read(&self, now: Time) -> Vec<Vec<u8>> {
        let mut items = EffectReader::new(&self.dictionary, now, &self.bytes);
        let mut bodies = Vec::new();
        while let Some(item) = items.read().unwrap() {
            let (kind, task) = item.kind().unwrap();
            let effect = item.effect().unwrap();
            assert_eq!(kind, EffectKind::of(&effect));
            assert_eq!(task, EffectKind::task_of(&effect).map(|task| task.0));
            bodies.push(item.body());
        }
        bodies
    }
}

fn bodies(effects: &[Effect]) -> Vec<Vec<u8>> {
    effects.iter().map(|effect| postcard::to_stdvec(effect).unwrap()).collect()
}

/// Postcard is the naive twin: every written effect is read back with the same bytes.
#[test]
fn effects_come_back_as_postcard_writes_them() {
    let mut written = Written::default();
    for _ in 0..4 {
        for (batch, effects) in samples::steps() {
            written.write(batch.now, &effects);
            assert_eq!(written.read(batch.now), bodies(&effects));
        }
    }
}

#[test]
fn kinds_are_called_as_the_describer_calls_them() {
    let mut describer = EffectDescriber::new(&samples::library());
    for (batch, effects) in samples::steps() {
        describer.hear(&batch);
        for effect in effects {
            let (told, kind) = (describer.tell(&effect), EffectKind::of(&effect));
            assert_eq!((kind.word, kind.to, kind.outcome), (told.kind, told.to, told.outcome));
            assert_eq!(EffectKind::task_of(&effect), told.task);
        }
    }
}

/// Returns a life of a task: five decisions.
fn life(task: u64, goal: Value) -> Vec<Effect> {
    let of = |kind: DecisionKind, cause: Cause| {
        Effect::Decided(Decision { task: Some(TaskId(task)), kind, because: Because::new(cause, samples::place(4)) })
    };
    let moves = |from, to, outcome| DecisionKind::Transition { from, to, outcome };
    let created = DecisionKind::Created {
        parent: Some(TaskId(2)),
        tag: samples::goal(&["s1"]).head().unwrap().clone(),
        goal: goal.clone(),
        place: samples::place(4),
    };
    let method = apex_model::effect::Method::BuiltIn;
    vec![
        of(created, Cause::ItemOf { parent: TaskId(2) }),
        of(moves(TaskState::Pending, TaskState::Enabled, None), Cause::NoPreconditions),
        of(DecisionKind::Selected { method, goal, alternatives: vec![] }, Cause::NoPreconditions),
        of(moves(TaskState::Enabled, TaskState::Ongoing, None), Cause::NoPreconditions),
        of(
            moves(TaskState::Ongoing, TaskState::Terminated, Some(Outcome::Success(Value::nil()))),
            Cause::IntervalElapsed,
        ),
    ]
}

#[test]
fn a_decision_takes_a_few_bytes() {
    let mut written = Written::default();
    let lives = |from: u64| (from..from + 300).flat_map(|task| life(task, goal_of(task))).collect::<Vec<_>>();
    written.write(Time::ZERO, &lives(10));
    let effects = lives(5_000);
    written.write(Time::from_seconds(60.0), &effects);
    assert_eq!(written.read(Time::from_seconds(60.0)), bodies(&effects));
    assert!(written.bytes.len() <= 7 * effects.len(), "{} bytes for {}", written.bytes.len(), effects.len());
}

fn goal_of(number: u64) -> Value {
    Value::list([Value::symbol("work"), Value::Integer(number as i64), Value::Real(number as f64 / 3.0)])
}

/// Returns the values of all types, with words that repeat and texts that do not.
fn value() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        any::<i64>().prop_map(Value::Integer),
        any::<f64>().prop_map(Value::Real),
        any::<i64>().prop_map(|at| Value::Time(Time(at))),
        any::<u64>().prop_map(|task| Value::Task(TaskId(task))),
        (0usize..5).prop_map(|word| Value::symbol(["fire", "zaca", "ä", "flight-path", "x"][word])),
        ".{0,20}".prop_map(|text| Value::text(&text)),
        (-5.0..5.0).prop_map(|number| samples::quantity(number, "deg")),
    ];
    leaf.prop_recursive(2, 8, 4, |inner| prop::collection::vec(inner, 0..4).prop_map(Value::list))
}

proptest! {
    #[test]
    fn any_effects_come_back(
        steps in prop::collection::vec((any::<i64>(), prop::collection::vec((0u64..40, value()), 0..60)), 1..6),
    ) {
        let mut written = Written::default();
        for (now, tasks) in steps {
            let effects: Vec<Effect> = tasks.into_iter().flat_map(|(task, value)| life(task, value)).collect();
            written.write(Time(now), &effects);
            prop_assert_eq!(written.read(Time(now)), bodies(&effects));
        }
    }
}

/// For any bytes, reading ends without a panic.
#[test]
fn damaged_bytes_are_refused_or_read() {
    let mut written = Written::default();
    let mut rows = Vec::new();
    for _ in 0..3 {
        for (batch, effects) in samples::steps() {
            written.write(batch.now, &effects);
            rows.push((batch.now, written.bytes.clone()));
        }
    }
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut refused = 0;
    for number in 0..20_000_usize {
        let (now, bytes) = &rows[number % rows.len()];
        let mut bytes = bytes.clone();
        let bits = random.next_u64();
        if !bytes.is_empty() {
            let place = (bits >> 16) as usize % bytes.len();
            match number % 3 {
                0 => bytes[place] ^= 1 << (bits & 7),
                1 => bytes[place] = bits as u8,
                _ => bytes.truncate(place),
            }
        }
        let mut items = EffectReader::new(&written.dictionary, *now, &bytes);
        loop {
            match items.read() {
                Ok(Some(item)) => drop((item.effect(), item.kind())),
                Ok(None) => break,
                Err(_) => {
                    refused += 1;
                    break;
                }
            }
        }
    }
    assert!(refused > 1_000, "{refused}");
}

#[test]
fn damaged_shapes_are_refused_without_panic() {
    let mut parts = Parts::default();
    let effect = life(7, goal_of(7)).remove(0);
    assert!(parts.split(Time::ZERO, &effect));
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut refused = 0;
    for _ in 0..5_000 {
        let mut layout = parts.shape.clone();
        let bits = random.next_u64();
        let place = (bits >> 16) as usize % layout.len();
        layout[place] = bits as u8;
        let example = vec![0; parts.values.len()];
        refused += usize::from(Dictionary::default().add_shape(layout, &example).is_err());
    }
    assert!(refused > 1_000, "{refused}");
}
