//! A cyclic condition (`conditions.md`, `:cyclic`) and its state: turning points and the run of cycles that they form.

use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::Satisfaction;
use apex_model::condition::CyclicCondition;
use apex_model::event::StateVariable;
use apex_model::quantity::Dimension;
use apex_model::time::Time;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// State of a cyclic condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CyclicPart {
    /// The condition.
    pub condition: Arc<CyclicCondition>,
    /// The state variable; `None` while its object is unknown.
    pub variable: Option<StateVariable>,
    /// Distance by which a value must return from an extreme to make it a turning point, SI.
    pub hysteresis: f64,
    /// True if the window reaches before the oldest sample that was kept when the monitor was made.
    pub blind: bool,
    /// Results that no later arrival of the same instant can withdraw.
    pub settled: Vec<Satisfaction>,
    /// State of each object.
    #[serde(with = "crate::state::pairs")]
    pub objects: BTreeMap<Value, CyclicObject>,
}

/// Samples of one object. The newest is separate, because a later arrival of its instant may still replace it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CyclicObject {
    /// Order of the object's first appearance.
    pub rank: u64,
    /// Bindings by the object's name; `None` if the object is not required.
    pub bindings: Option<Bindings>,
    /// The newest sample; NaN if its value is not a number.
    pub newest: (Time, f64),
    /// State before the newest sample.
    pub swing: Swing,
}

/// An extreme of the values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extreme {
    /// Instant of the first sample that has the value.
    pub at: Time,
    /// The value, SI.
    pub value: f64,
    /// Number of the sample, from 1.
    pub number: u64,
}

/// Direction of the values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Heading {
    /// The values have not changed by the hysteresis yet.
    #[default]
    Unknown,
    /// Up, since the last turning point.
    Rising,
    /// Down, since the last turning point.
    Falling,
}

/// State of one object's samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Swing {
    /// Direction of the values.
    pub heading: Heading,
    /// The least value since the last turning point, or since the beginning.
    pub lowest: Option<Extreme>,
    /// The greatest one.
    pub highest: Option<Extreme>,
    /// The last two turning points, the older first.
    pub turns: [Option<Extreme>; 2],
    /// Number of samples.
    pub samples: u64,
    /// The dimension of the values.
    pub dimension: Dimension,
    /// The run of cycles that the last turning point belongs to.
    pub run: Option<CycleRun>,
    /// True if a cycle has contradicted the constraints.
    pub contradicted: bool,
    /// Instants of the first and the last turning point of the last complete cycle, and its amplitude, SI.
    pub last: Option<(Time, Time, f64)>,
}

/// Successive cycles that all satisfy the constraints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CycleRun {
    /// The first turning point.
    pub start: Extreme,
    /// The last turning point.
    pub end: Extreme,
    /// Number of half cycles.
    pub halves: u64,
    /// Sum of the amplitudes of all cycles that begin at one of its turning points, SI.
    pub amplitudes: f64,
    /// True if the run was reported.
    pub told: bool,
}
