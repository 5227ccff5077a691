//! Monitors of one session to measure, and the traces watched by them and by the peers.
#![allow(clippy::unwrap_used, reason = "a measurement that cannot be set up must stop at once")]

use apex_executive::MonitorSession;
use apex_model::condition::Condition;
use apex_model::event::StateVariable;
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_pdl::{CheckOptions, SourceText, check_conditions};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::sync::Arc;

/// Nanoseconds between two samples: 50 Hz.
pub const PERIOD_NS: i64 = 20_000_000;

/// Returns the conditions that `texts` are, and the library that `declarations` make.
///
/// # Panics
/// If a text is not a condition.
pub fn conditions(declarations: &str, texts: &[String]) -> (Arc<Library>, Vec<Condition>) {
    let source = |name: &str, text: &str| SourceText { name: name.to_string(), text: text.to_string() };
    let mut resolve = |_| Err("nothing is required".into());
    let options = CheckOptions { fragment: false, host: &[], resolve: &mut resolve };
    let sources = texts.iter().map(|text| source("condition", text)).collect();
    let read = check_conditions(vec![source("declarations", declarations)], sources, options);
    assert!(!read.checked.has_errors(), "{:?}", read.checked.diagnostics);
    (Arc::new(read.checked.library), read.conditions)
}

/// Returns a session that watches all of `texts` from the beginning.
///
/// # Panics
/// If a text is not a condition that can be watched.
pub fn session(texts: &[String]) -> MonitorSession {
    let (library, conditions) = conditions("", texts);
    let mut session = MonitorSession::new(library, HostFunctions::default()).unwrap();
    for condition in conditions {
        session.watch(condition, Time::BEGINNING).unwrap();
    }
    session
}

/// Returns variable number `number`: `(x0 uav)`, `(x1 uav)`, ..
pub fn variable(number: usize) -> StateVariable {
    StateVariable::new(Symbol::new(&format!("x{number}")), Value::symbol("uav"))
}

/// Returns the instant of sample number `index`.
pub fn instant(index: usize) -> Time {
    Time(PERIOD_NS * (index as i64 + 1))
}

/// Random numbers of a seed, in [0, 1).
pub struct Numbers(ChaCha8Rng);

impl Numbers {
    /// Returns the sequence of `seed`.
    pub fn new(seed: u64) -> Numbers {
        Numbers(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Returns the next one.
    pub fn draw(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Returns a signal like an aircraft's roll angle: slow turns with some noise, from -30 to 30.
pub fn smooth(samples: usize, seed: u64) -> Vec<f64> {
    let mut numbers = Numbers::new(seed);
    (0..samples)
        .map(|index| {
            let t = index as f64 * 0.02;
            22.0 * libm::sin(t * 0.7 + seed as f64) + 6.0 * libm::sin(t * 2.3) + 2.0 * (numbers.draw() - 0.5)
        })
        .collect()
}

/// Returns the worst signal: each sample anywhere from -30 to 30.
pub fn noise(samples: usize, seed: u64) -> Vec<f64> {
    let mut numbers = Numbers::new(seed);
    (0..samples).map(|_| 60.0 * numbers.draw() - 30.0).collect()
}

fn bound(numbers: &mut Numbers) -> f64 {
    libm::round((numbers.draw() * 50.0 - 25.0) * 100.0) / 100.0
}

/// Episodes of values above different bounds: `(> b)`.
pub fn value_episodes(count: usize) -> Vec<String> {
    let mut numbers = Numbers::new(1);
    (0..count)
        .map(|_| format!("(:episode (x0 uav) :quality :no-constraints :value (> {}))", bound(&mut numbers)))
        .collect()
}

/// Episodes of values above different bounds, for different times and with a greatest gap.
pub fn duration_episodes(count: usize) -> Vec<String> {
    let mut numbers = Numbers::new(2);
    (0..count)
        .map(|_| {
            let (bound, tenths) = (bound(&mut numbers), 1 + (numbers.draw() * 100.0) as u32);
            let duration = f64::from(tenths) / 10.0;
            format!(
                "(:episode (x0 uav) :quality (:max-gap 1s) :value (> {bound}) :timing (:duration (>= {duration}s)))"
            )
        })
        .collect()
}

/// Variables that the mixed monitors watch.
pub const MIXED_VARIABLES: usize = 10;

/// Returns all kinds of conditions, with the variables that each watches: half threshold episodes, a quarter single samples, a quarter
/// combinations of two variables.
pub fn mixed(count: usize) -> (Vec<String>, usize) {
    let mut numbers = Numbers::new(3);
    let mut relevant = 0;
    let texts = (0..count)
        .map(|index| {
            let (a, b) = (index % MIXED_VARIABLES, (index / 3 + 1) % MIXED_VARIABLES);
            let (least, other) = (bound(&mut numbers), bound(&mut numbers));
            let episode = |x: usize, least: f64, duration: &str| {
                format!("(:episode (x{x} uav) :quality (:max-gap 1s) :value (> {least}) :timing (:duration (>= {duration})))")
            };
            relevant += if index % 20 < 15 || a == b { 1 } else { 2 };
            match index % 20 {
                0..5 => format!("(:episode (x{a} uav) :quality :no-constraints :value (> {least}))"),
                5..10 => episode(a, least, "2s"),
                10..15 => format!("(x{a} uav > {})", least + 40.0),
                15 | 16 => format!("(:and {} {})", episode(a, least, "1s"), episode(b, other, "2s")),
                17 => format!("(:or {} {})", episode(a, least, "1s"), episode(b, other, "5s")),
                18 => format!("(:in-order {} {})", episode(a, least, "1s"), episode(b, other, "1s")),
                _ => format!("(:and {} (:not {}))", episode(a, least, "1s"), episode(b, other, "1s")),
            }
        })
        .collect();
    (texts, relevant)
}
