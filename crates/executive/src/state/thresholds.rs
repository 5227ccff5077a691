//! Monitors of one state variable, sorted by the bounds of their comparisons, so that a sample touches only those whose comparison can be
//! true.

use crate::planted::{self, Bug};
use crate::state::clause::MonitorId;
use crate::state::monitor_set::MonitorIds;
use apex_model::condition::Relation;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// A comparison with a constant number that a sample must satisfy to satisfy the condition.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Threshold {
    /// The side of the bound on which a sample must be.
    pub side: Side,
    /// The bound in SI; never NaN.
    pub bound: f64,
    /// Its dimension.
    pub dimension: Dimension,
}

/// Sides of a bound, the bound itself included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Side {
    /// At least the bound.
    Above,
    /// At most the bound.
    Below,
    /// Just the bound.
    At,
}

impl Threshold {
    /// Returns the threshold of `relation` to `right`; `None` if samples of every size may satisfy it, or none can.
    pub fn of(relation: Relation, right: &Value) -> Option<Threshold> {
        let (bound, dimension) = right.as_number().filter(|(bound, _)| !bound.is_nan())?;
        let side = match relation {
            Relation::Greater | Relation::GreaterOrEqual => Side::Above,
            Relation::Less | Relation::LessOrEqual => Side::Below,
            Relation::Equal => Side::At,
            Relation::Different => return None,
        };
        Some(Threshold { side, bound, dimension })
    }
}

/// Monitors by threshold.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Thresholds(Vec<OfDimension>);

/// Thresholds of one dimension. A sample of another dimension reaches all monitors, because the comparison is an error to report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct OfDimension {
    dimension: Dimension,
    above: BTreeSet<(Key, MonitorId)>,
    below: BTreeSet<(Key, MonitorId)>,
    at: BTreeSet<(Key, MonitorId)>,
}

/// A bound as a number in the order of bounds; both zeros are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
struct Key(u64);

impl Key {
    fn of(bound: f64) -> Key {
        let bits = (bound + 0.0).to_bits();
        Key(if bits >> 63 == 0 { bits | 1 << 63 } else { !bits })
    }
}

const FIRST: MonitorId = MonitorId(0);
const LAST: MonitorId = MonitorId(u64::MAX);

impl OfDimension {
    fn side(&mut self, side: Side) -> &mut BTreeSet<(Key, MonitorId)> {
        match side {
            Side::Above => &mut self.above,
            Side::Below => &mut self.below,
            Side::At => &mut self.at,
        }
    }

    fn is_empty(&self) -> bool {
        self.above.is_empty() && self.below.is_empty() && self.at.is_empty()
    }
}

impl Thresholds {
    /// Files `monitor` under its threshold.
    pub fn insert(&mut self, threshold: Threshold, monitor: MonitorId) {
        let key = (Key::of(threshold.bound), monitor);
        if let Some(group) = self.0.iter_mut().find(|group| group.dimension == threshold.dimension) {
            group.side(threshold.side).insert(key);
            return;
        }
        let (above, below, at) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
        let mut group = OfDimension { dimension: threshold.dimension, above, below, at };
        group.side(threshold.side).insert(key);
        self.0.push(group);
    }

    /// Removes `monitor`. Returns false if it was not there.
    pub fn remove(&mut self, threshold: Threshold, monitor: MonitorId) -> bool {
        let Some(index) = self.0.iter().position(|group| group.dimension == threshold.dimension) else { return false };
        let Some(group) = self.0.get_mut(index) else { return false };
        let found = group.side(threshold.side).remove(&(Key::of(threshold.bound), monitor));
        if group.is_empty() {
            self.0.remove(index);
        }
        found
    }

    /// Returns true if there are no monitors.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Finds the monitors whose comparison with `value` may be true, or an error.
    pub fn of_value(&self, value: &Value, found: &mut MonitorIds) {
        let number = value.as_number().filter(|(number, _)| !number.is_nan());
        for group in &self.0 {
            match number {
                Some((number, dimension)) if dimension == group.dimension => {
                    let key = Key::of(number);
                    let last = if planted::is(Bug::ThresholdMisses) { FIRST } else { LAST };
                    found.extend(group.above.range(..=(key, last)).map(|(_, monitor)| *monitor));
                    found.extend(group.below.range((key, FIRST)..).map(|(_, monitor)| *monitor));
                    found.extend(group.at.range((key, FIRST)..=(key, LAST)).map(|(_, monitor)| *monitor));
                }
                _ => group.all(found),
            }
        }
    }

    /// Calls a function for all monitors.
    pub fn all(&self, found: &mut MonitorIds) {
        self.0.iter().for_each(|group| group.all(found));
    }
}

impl OfDimension {
    fn all(&self, found: &mut MonitorIds) {
        for side in [&self.above, &self.below, &self.at] {
            found.extend(side.iter().map(|(_, monitor)| *monitor));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::time::Duration;

    fn of(thresholds: &Thresholds, value: Value) -> Vec<u64> {
        let mut found = MonitorIds::new();
        thresholds.of_value(&value, &mut found);
        found.sort_unstable();
        found.iter().map(|monitor| monitor.0).collect()
    }

    #[test]
    fn only_bounds_on_the_right_side_are_found() {
        let mut thresholds = Thresholds::default();
        let bounds = [
            (Relation::Greater, Value::Integer(5)),
            (Relation::GreaterOrEqual, Value::Real(-3.5)),
            (Relation::Less, Value::Integer(0)),
            (Relation::Equal, Value::Real(-0.0)),
            (Relation::Greater, Value::Duration(Duration(7))),
        ];
        for (number, (relation, right)) in (0..).zip(&bounds) {
            thresholds.insert(Threshold::of(*relation, right).unwrap(), MonitorId(number));
        }
        // The bound in seconds receives every plain number, because that comparison is an error to report.
        assert_eq!(of(&thresholds, Value::Integer(6)), [0, 1, 4]);
        assert_eq!(of(&thresholds, Value::Integer(0)), [1, 2, 3, 4]);
        assert_eq!(of(&thresholds, Value::Real(-4.0)), [2, 4]);
        assert_eq!(of(&thresholds, Value::Duration(Duration(7))), [0, 1, 2, 3, 4]);
        assert_eq!(of(&thresholds, Value::Duration(Duration(6))), [0, 1, 2, 3]);
        assert_eq!(of(&thresholds, Value::symbol("idle")), [0, 1, 2, 3, 4]);
        for (number, (relation, right)) in (0..).zip(&bounds) {
            assert!(thresholds.remove(Threshold::of(*relation, right).unwrap(), MonitorId(number)));
        }
        assert!(thresholds.is_empty());
    }

    #[test]
    fn a_bound_that_no_number_has_is_not_a_threshold() {
        assert_eq!(Threshold::of(Relation::Greater, &Value::Real(f64::NAN)), None);
        assert_eq!(Threshold::of(Relation::Equal, &Value::symbol("idle")), None);
        assert_eq!(Threshold::of(Relation::Different, &Value::Integer(1)), None);
    }
}
