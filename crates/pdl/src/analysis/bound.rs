//! Variables that patterns and conditions bind: certainly, at every match, or only in some of their alternatives.

use apex_model::condition::{Condition, ConditionKind, Constraint};
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

/// Variables, by the certainty of their binding.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bound<'l> {
    /// Have a value whenever the match succeeded.
    pub(crate) surely: BTreeSet<&'l Symbol>,
    /// Bound after some matches; with the condition that binds them, if it is one.
    pub(crate) perhaps: BTreeMap<&'l Symbol, Option<Place>>,
    /// Occurs only below a negation, where it is not bound.
    pub(crate) never: BTreeMap<&'l Symbol, Option<Place>>,
}

impl<'l> Bound<'l> {
    fn one(name: &'l Symbol) -> Bound<'l> {
        Bound { surely: BTreeSet::from([name]), ..Bound::default() }
    }

    fn is_nothing(&self) -> bool {
        self.surely.is_empty() && self.perhaps.is_empty() && self.never.is_empty()
    }

    /// Returns the variables bound if both match.
    pub(crate) fn and(mut self, other: Bound<'l>) -> Bound<'l> {
        if self.is_nothing() {
            return other;
        }
        self.surely.extend(other.surely);
        self.perhaps.extend(other.perhaps);
        self.never.extend(other.never);
        self
    }

    /// Returns the variables bound if one of them matches.
    fn or(parts: Vec<Bound<'l>>, places: impl Iterator<Item = Option<Place>>) -> Bound<'l> {
        let mut result = Bound::default();
        let mut shared: Option<BTreeSet<&'l Symbol>> = None;
        for (part, place) in parts.iter().zip(places) {
            shared = Some(match shared {
                Some(shared) => shared.intersection(&part.surely).copied().collect(),
                None => part.surely.clone(),
            });
            result.perhaps.extend(part.surely.iter().map(|name| (*name, place)));
            result.perhaps.extend(part.perhaps.iter().map(|(name, place)| (*name, *place)));
            result.never.extend(part.never.iter().map(|(name, place)| (*name, *place)));
        }
        result.surely = shared.unwrap_or_default();
        result
    }

    /// Removes the bindings that are not visible outside.
    fn hidden(self, place: Option<Place>) -> Bound<'l> {
        let names = self.surely.into_iter().chain(self.perhaps.into_keys()).chain(self.never.into_keys());
        Bound { never: names.map(|name| (name, place)).collect(), ..Bound::default() }
    }
}

/// Returns the bindings of a pattern.
pub(crate) fn by_pattern(pattern: &Pattern) -> Bound<'_> {
    match pattern {
        Pattern::Variable(name) | Pattern::Is { variable: name, .. } => Bound::one(name),
        Pattern::Segment { variable: Some(name), .. } => Bound::one(name),
        Pattern::List(parts) | Pattern::And(parts) => parts.iter().map(by_pattern).fold(Bound::default(), Bound::and),
        Pattern::Or(parts) => Bound::or(parts.iter().map(by_pattern).collect(), std::iter::repeat_n(None, parts.len())),
        Pattern::Not(part) => by_pattern(part).hidden(None),
        Pattern::Literal(_)
        | Pattern::BoundVariable(_)
        | Pattern::Anonymous
        | Pattern::Computed(_)
        | Pattern::Segment { variable: None, .. }
        | Pattern::Guard(_) => Bound::default(),
    }
}

/// Returns the bindings of a satisfied condition, its tag included.
pub(crate) fn by_condition(condition: &Condition) -> Bound<'_> {
    let place = Some(condition.place);
    let inner = match &condition.kind {
        ConditionKind::Measurement(measurement) => by_pattern(&measurement.variable.object)
            .and(by_constraints(&measurement.value))
            .and(by_constraints(&measurement.object)),
        ConditionKind::Episode(episode) => by_pattern(&episode.variable.object)
            .and(by_constraints(&episode.value))
            .and(by_constraints(&episode.first_value))
            .and(by_constraints(&episode.last_value))
            .and(by_constraints(&episode.object)),
        ConditionKind::And(parts, _) | ConditionKind::InOrder(parts, _) | ConditionKind::Allen { parts, .. } => {
            parts.iter().map(by_condition).fold(Bound::default(), Bound::and)
        }
        ConditionKind::Or(parts, _) => {
            Bound::or(parts.iter().map(by_condition).collect(), parts.iter().map(|part| Some(part.place)))
        }
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => by_condition(part).hidden(place),
        ConditionKind::Event { pattern, .. } => by_pattern(pattern),
        ConditionKind::TaskState { state, .. } => by_pattern(state),
        ConditionKind::Probing { condition, .. } => by_condition(condition),
        ConditionKind::Cyclic(cyclic) => by_pattern(&cyclic.variable.object),
        ConditionKind::Delay(..)
        | ConditionKind::Timestamp(..)
        | ConditionKind::TaskEnded(_)
        | ConditionKind::Function(_) => Bound::default(),
    };
    match &condition.tag {
        Some(tag) => inner.and(Bound::one(tag)),
        None => inner,
    }
}

fn by_constraints(constraints: &[Constraint]) -> Bound<'_> {
    let patterns = constraints.iter().filter_map(|constraint| match constraint {
        Constraint::Matches(pattern) => Some(by_pattern(pattern)),
        _ => None,
    });
    patterns.fold(Bound::default(), Bound::and)
}

/// Returns the bindings of conditions that all hold.
pub(crate) fn by_all(conditions: &[Condition]) -> Bound<'_> {
    conditions.iter().map(by_condition).fold(Bound::default(), Bound::and)
}
