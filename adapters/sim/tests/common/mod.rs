//! Shared by the tests of the simulator: a world with a counter of commands, and readers of its reports.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that fails should stop")]
#![allow(dead_code, reason = "each test file uses its own part")]

use apex_model::effect::CommandId;
use apex_model::event::EventKind;
use apex_model::problem::{FOREVER_S, WindField, WindLayer};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::ports::{Input, Vehicle};
use apex_sim::{SimulatedWorld, Start, WorldConfig};
use apex_vehicle::VehicleModel;

pub(crate) struct Run {
    pub(crate) world: SimulatedWorld,
    pub(crate) inputs: Vec<Input>,
    pub(crate) now: Time,
    next: u64,
}

impl Run {
    pub(crate) fn new(config: WorldConfig) -> Run {
        Run { world: SimulatedWorld::new(config).unwrap(), inputs: Vec::new(), now: Time::ZERO, next: 1 }
    }

    pub(crate) fn send(&mut self, form: Value) -> CommandId {
        let id = CommandId(self.next);
        self.next += 1;
        self.world.command(id, &form, self.now);
        id
    }

    pub(crate) fn wait_s(&mut self, seconds: f64) {
        self.now = self.now + Duration::from_seconds(seconds);
        self.world.advance(self.now, &mut self.inputs).unwrap();
    }

    /// Waits in the same way as the runtime: from announced instant to announced instant. Each input must have exactly that instant.
    pub(crate) fn wait_watchfully_s(&mut self, seconds: f64) {
        let end = self.now + Duration::from_seconds(seconds);
        loop {
            let next = self.world.next_report().unwrap();
            assert!(next >= self.now, "{next} was announced at {}", self.now);
            let instant = next.min(end);
            let before = self.inputs.len();
            self.world.advance(instant, &mut self.inputs).unwrap();
            for input in &self.inputs[before..] {
                assert_eq!((input.at, input.at.0 % 1_000_000), (instant, 0), "{:?}", input.kind);
            }
            self.now = instant;
            if next > end {
                return;
            }
        }
    }

    /// Sends `form` and waits for the answer, at most `seconds`; time stops at the answer.
    pub(crate) fn carry_out(&mut self, form: Value, seconds: f64) -> Result<Value, String> {
        let id = self.send(form);
        self.await_answer(id, seconds)
    }

    pub(crate) fn await_answer(&mut self, id: CommandId, seconds: f64) -> Result<Value, String> {
        let end = self.now + Duration::from_seconds(seconds);
        let mut read = 0;
        loop {
            let found = self.answer_from(read, id);
            read = self.inputs.len();
            if let Some((at, answer)) = found {
                self.now = self.now.max(at);
                return answer;
            }
            let next = self.world.next_report().unwrap();
            assert!(next <= end, "no answer within {seconds} s; last: {:?}", self.last_number("distance-to-go"));
            self.now = next;
            self.world.advance(next, &mut self.inputs).unwrap();
        }
    }

    pub(crate) fn answer(&self, id: CommandId) -> Option<(Time, Result<Value, String>)> {
        self.answer_from(0, id)
    }

    /// Returns the answer among the inputs from this index on.
    fn answer_from(&self, begin: usize, id: CommandId) -> Option<(Time, Result<Value, String>)> {
        self.inputs[begin..].iter().find_map(|input| match &input.kind {
            EventKind::CommandAcknowledged(found, result) if *found == id => Some((input.at, result.clone())),
            _ => None,
        })
    }

    /// Returns all samples of `attribute` as `(seconds, SI number)`.
    pub(crate) fn numbers(&self, attribute: &str) -> Vec<(f64, f64)> {
        self.values(attribute)
            .into_iter()
            .map(|(at, value)| (at, value.as_number().unwrap_or((f64::NAN, Default::default())).0))
            .collect()
    }

    pub(crate) fn values(&self, attribute: &str) -> Vec<(f64, Value)> {
        let of = |input: &Input| match &input.kind {
            EventKind::Measurement(variable, value) if variable.attribute.is(attribute) => {
                Some((input.at.seconds(), value.clone()))
            }
            _ => None,
        };
        self.inputs.iter().filter_map(of).collect()
    }

    pub(crate) fn last_number(&self, attribute: &str) -> f64 {
        self.numbers(attribute).last().unwrap().1
    }

    /// Returns the instant of the event `form` (as text).
    pub(crate) fn event(&self, form: &str) -> Option<f64> {
        self.inputs.iter().find_map(|input| match &input.kind {
            EventKind::Occurrence(value) if value.to_string() == form => Some(input.at.seconds()),
            _ => None,
        })
    }
}

pub(crate) fn predator(start: Start) -> WorldConfig {
    WorldConfig::new("aircraft-1", VehicleModel::named("predator-b").unwrap(), start)
}

pub(crate) fn rmax(start: Start) -> WorldConfig {
    WorldConfig::new("rmax-1", VehicleModel::named("rmax").unwrap(), start)
}

pub(crate) fn wind(east_mps: f64, north_mps: f64, edr: f64) -> WindField {
    let layer = WindLayer {
        area: None,
        altitude_m_min: -1e3,
        altitude_m_max: 3e4,
        from_s: -FOREVER_S,
        until_s: FOREVER_S,
        wind_east_mps: east_mps,
        wind_north_mps: north_mps,
        edr,
    };
    WindField { layers: vec![layer], blend: false }
}

pub(crate) fn word(name: &str) -> Value {
    Value::symbol(name)
}

pub(crate) fn location(latitude_deg: f64, longitude_deg: f64) -> Value {
    Value::list([Value::Real(latitude_deg), Value::Real(longitude_deg)])
}

pub(crate) fn form(name: &str, arguments: impl IntoIterator<Item = Value>) -> Value {
    Value::list([word(name)].into_iter().chain(arguments))
}
