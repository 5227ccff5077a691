//! All ways in which a condition is satisfied at an instant.

use crate::condition::{Allen, Condition, Constraint, Edge, Kind, Relation, Span, Term, Test, Time};
use crate::history::{Past, known};
use crate::value::{Bindings, Value, joined, numbers};
use crate::verdict::Question;
use std::collections::BTreeMap;

/// First and last evidence, both included.
pub type Interval = (Time, Time);

/// One way in which a condition is satisfied.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Way {
    /// First and last evidence; `None` if no evidence was needed.
    pub(crate) hull: Option<Interval>,
    /// The evidence may still continue.
    pub(crate) open: bool,
    /// The instant up to which the values behind it persist beyond its evidence; `None` if nothing persists.
    pub(crate) lasts: Option<Time>,
    /// True if the way holds at this instant and may not hold at the next.
    pub(crate) instant: bool,
    /// Instant at which the way would have been known without late arrivals; ways are ordered by it.
    pub(crate) known: Time,
    pub(crate) bound: Bindings,
    pub(crate) tags: BTreeMap<String, Interval>,
}

impl Way {
    pub(crate) fn at(at: Time, known: Time) -> Way {
        Way::over((at, at), known, Bindings::new())
    }

    /// Returns a way that holds at this instant and may not hold at the next.
    fn now(view: View<'_>) -> Way {
        Way { instant: true, ..Way::at(view.now, view.now) }
    }

    pub(crate) fn over(interval: Interval, known: Time, bound: Bindings) -> Way {
        Way { hull: Some(interval), open: false, lasts: None, instant: false, known, bound, tags: BTreeMap::new() }
    }

    fn nothing(created: Time) -> Way {
        Way {
            hull: None,
            open: false,
            lasts: None,
            instant: false,
            known: created,
            bound: Bindings::new(),
            tags: BTreeMap::new(),
        }
    }

    /// Returns both ways as one, or `None` if they give a variable different values.
    fn with(&self, next: &Way) -> Option<Way> {
        let hull = match (self.hull, next.hull) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
            (a, b) => a.or(b),
        };
        let mut tags = self.tags.clone();
        tags.extend(next.tags.clone());
        let bound = joined(&self.bound, &next.bound)?;
        let lasts = self.lasts.into_iter().chain(next.lasts).min();
        let (open, instant) = (self.open || next.open, self.instant || next.instant);
        Some(Way { hull, open, lasts, instant, known: self.known.max(next.known), bound, tags })
    }
}

/// The intervals of a run that count as its results (rule 7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Runs {
    /// From the first sample of the run up to the one that proves it.
    Begun,
    /// Any two samples of the run: for `:in-order`.
    Any,
    /// The whole run, as far as it is known: for Allen's relations.
    Whole,
}

/// Context in which a condition is judged: the knowledge, the instant from which evidence counts, and the present instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View<'a> {
    pub(crate) question: &'a Question,
    pub(crate) past: &'a Past,
    pub(crate) created: Time,
    pub(crate) now: Time,
    pub(crate) runs: Runs,
}

/// The ways, and the state of knowledge if there is none.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Ways {
    pub(crate) all: Vec<Way>,
    /// Reason if the way is unknown.
    pub(crate) unknown: Option<String>,
    /// True if it is unknown whether a part continues or holds, even if there are ways.
    pub(crate) doubt: bool,
}

impl From<Vec<Way>> for Ways {
    fn from(all: Vec<Way>) -> Ways {
        Ways { all, ..Ways::default() }
    }
}

/// Returns all ways, those that became known earlier first.
pub(crate) fn ways(condition: &Condition, view: View<'_>) -> Ways {
    let mut ways = of_kind(condition, view);
    ways.all.retain(|way| way.known <= view.now);
    if let Some(tag) = &condition.tag {
        for way in &mut ways.all {
            way.tags.extend(way.hull.map(|hull| (tag.clone(), hull)));
        }
    }
    // Rule 16: tests see all tags, including the composite's tag.
    if let Kind::And(_, tests) | Kind::InOrder(_, tests) | Kind::Allen { tests, .. } = &condition.kind {
        ways.all.retain(|way| tests.iter().all(|test| passes(test, way)));
    }
    ways.all.sort_by_key(|way| way.known);
    ways.doubt = if ways.all.is_empty() || !knows_its_doubt(condition) { ways.unknown.is_some() } else { ways.doubt };
    ways
}

/// Returns true if the condition itself states which ways are undecided.
fn knows_its_doubt(condition: &Condition) -> bool {
    use Kind::{Absent, Allen, And, Episode, InOrder, Not, Or};
    matches!(condition.kind, Episode(_) | And(..) | Or(_) | Not(_) | Absent(..) | InOrder(..) | Allen { .. })
}

fn of_kind(condition: &Condition, view: View<'_>) -> Ways {
    match &condition.kind {
        Kind::Measurement(measurement) => crate::measurement::ways(measurement, view),
        Kind::Episode(episode) => crate::episode::ways(episode, view),
        Kind::Cyclic(cyclic) => crate::cyclic::ways(cyclic, view),
        Kind::And(parts, _) => all_of(parts, view),
        Kind::Or(parts) => one_of(parts, view),
        Kind::Not(part) => no_result(part, view),
        Kind::Absent(part, span) => crate::absence::ways(part, *span, view),
        Kind::InOrder(parts, _) => {
            // Where delays are counted, an episode lies between any two samples of a run.
            let delayed = parts.iter().any(|part| matches!(part.kind, Kind::Delay(..)));
            in_order(parts, View { runs: if delayed { Runs::Any } else { view.runs }, ..view })
        }
        Kind::Allen { relation, parts, tolerance, .. } => {
            related(*relation, parts, *tolerance, View { runs: Runs::Whole, ..view })
        }
        Kind::Delay(least, most) => delay(*least, *most, view),
        Kind::Timestamp(from, to) => timestamp(*from, *to, view),
        Kind::Event(pattern, when) => crate::event::messages(pattern, when, view),
        Kind::Function(attribute, object, relation, number) => {
            function((attribute.as_str(), object.as_str()), *relation, *number, view)
        }
        Kind::TaskEnded(task) => crate::event::task_states(task, "terminated", view),
        Kind::TaskState(task, state) => crate::event::task_states(task, state, view),
    }
}

/// `:and`: returns combinations of a way of each part that agree about their variables, without those that are forbidden by a `:not` next
/// to the parts.
fn all_of(parts: &[Condition], view: View<'_>) -> Ways {
    let (forbidding, asking): (Vec<_>, Vec<_>) = parts.iter().partition(|part| matches!(part.kind, Kind::Not(_)));
    let mut found = Ways::from(vec![Way::nothing(view.created)]);
    let mut truth = Kleene::default();
    for part in asking {
        let next = ways(part, view);
        truth.and(&next);
        found.all = combined(&found.all, &next.all, |_, _| true);
    }
    for part in &forbidding {
        let Kind::Not(inner) = &part.kind else { continue };
        let against = ways(inner, view);
        // A result of the part excludes all combinations, unless it binds a variable that the other parts also bind.
        let shared = |name: &String| parts.iter().any(|other| !std::ptr::eq(other, *part) && binds(other, name));
        if against.all.is_empty() || against.all.iter().any(|way| !way.bound.keys().any(shared)) {
            truth.and(&no_result(inner, view));
        }
        let undecided = against.all.is_empty() && against.unknown.is_some();
        found
            .all
            .retain(|way| !undecided && !against.all.iter().any(|other| joined(&way.bound, &other.bound).is_some()));
    }
    for way in &mut found.all {
        if !forbidding.is_empty() || way.hull.is_none() {
            way.known = view.now;
        }
        way.instant |= !forbidding.is_empty();
        way.hull = way.hull.or(Some((view.now, view.now)));
    }
    found.doubt = truth.doubt;
    found.unknown = truth.unknown();
    found
}

/// Returns true if the condition can bind the variable.
fn binds(condition: &Condition, name: &str) -> bool {
    let is = |term: &Term| matches!(term, Term::Variable(own) if own == name);
    match &condition.kind {
        Kind::Measurement(measurement) => {
            is(&measurement.variable.object)
                || measurement.value.iter().any(|constraint| matches!(constraint, Constraint::Bind(own) if own == name))
        }
        Kind::Episode(episode) => is(&episode.variable.object),
        Kind::Cyclic(cyclic) => is(&cyclic.variable.object),
        Kind::Event(pattern, _) => pattern.iter().any(is),
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) | Kind::Allen { parts, .. } => {
            parts.iter().any(|part| binds(part, name))
        }
        Kind::Not(part) | Kind::Absent(part, _) => binds(part, name),
        Kind::Delay(..) | Kind::Timestamp(..) | Kind::Function(..) | Kind::TaskEnded(_) | Kind::TaskState(..) => false,
    }
}

/// Kleene's "and": a false part decides; otherwise an unknown part makes the result unknown (rule 3).
#[derive(Default)]
struct Kleene {
    fails: bool,
    doubt: bool,
    reason: Option<String>,
}

impl Kleene {
    fn and(&mut self, part: &Ways) {
        self.doubt |= part.doubt;
        if part.all.is_empty() {
            self.fails |= part.unknown.is_none();
            self.reason = self.reason.take().or(part.unknown.clone());
        }
    }

    fn unknown(self) -> Option<String> {
        self.reason.filter(|_| !self.fails)
    }
}

/// `:or`: returns the ways of all parts, those of earlier parts first.
fn one_of(parts: &[Condition], view: View<'_>) -> Ways {
    let mut found = Ways::default();
    for part in parts {
        let next = ways(part, view);
        found.all.extend(next.all);
        found.unknown = found.unknown.or(next.unknown);
        found.doubt |= next.doubt;
    }
    found
}

/// Rule 14: holds at an instant when its part has no result up to then.
fn no_result(part: &Condition, view: View<'_>) -> Ways {
    let part = ways(part, view);
    match part {
        Ways { all, .. } if !all.is_empty() => Ways::default(),
        Ways { unknown: None, .. } => vec![Way::now(view)].into(),
        Ways { unknown, doubt, .. } => Ways { all: Vec::new(), unknown, doubt },
    }
}

/// `:in-order`: returns combinations in which the end of each part is before the start of the next; a delay between them sets the distance.
fn in_order(parts: &[Condition], view: View<'_>) -> Ways {
    let mut found = Ways::from(vec![Way::nothing(view.created)]);
    let mut delay: Option<(Span, Span)> = None;
    let mut truth = Kleene::default();
    for part in parts {
        if let Kind::Delay(least, most) = part.kind {
            // Delays in a row add up.
            let (before_least, before_most) = delay.unwrap_or((0, 0));
            delay = Some((before_least + least, before_most.saturating_add(most.unwrap_or(Span::MAX))));
            continue;
        }
        let next = ways(part, view);
        truth.and(&next);
        found.all = combined(&found.all, &next.all, |before, next| {
            let end = before.hull.map_or(view.created, |hull| hull.1);
            let between = next.hull.map_or(view.now, |hull| hull.0) - end;
            match delay {
                Some((least, most)) => (least..=most).contains(&between),
                None => before.hull.is_none() || between > 0,
            }
        });
        delay = None;
    }
    if let Some((least, _)) = delay {
        for way in &mut found.all {
            way.known = way.known.max(way.hull.map_or(view.created, |hull| hull.1) + least);
        }
    }
    for way in &mut found.all {
        way.hull = way.hull.or(Some((way.known, way.known)));
    }
    found.doubt = truth.doubt;
    found.unknown = truth.unknown();
    found
}

/// Returns combinations with this one of Allen's relations between neighbours, as soon as no continuation of a run can change the result
/// (rule 15).
fn related(relation: Allen, parts: &[Condition], tolerance: Span, view: View<'_>) -> Ways {
    let mut chains: Vec<(Way, Way)> = Vec::new();
    let mut truth = Kleene::default();
    for (index, part) in parts.iter().enumerate() {
        let next = ways(part, view);
        truth.and(&next);
        if index == 0 {
            chains = next.all.iter().map(|way| (way.clone(), way.clone())).collect();
            continue;
        }
        let mut longer = Vec::new();
        for (whole, last) in &chains {
            for way in next.all.iter().filter(|way| crate::allen::decided(relation, last, way, tolerance)) {
                longer.extend(whole.with(way).map(|joined| (joined, way.clone())));
            }
        }
        chains = longer;
    }
    Ways { all: chains.into_iter().map(|(whole, _)| whole).collect(), doubt: truth.doubt, unknown: truth.unknown() }
}

fn delay(least: Span, most: Option<Span>, view: View<'_>) -> Ways {
    let over = view.created + least;
    if most.is_some_and(|most| most < least) {
        return Ways::default();
    }
    vec![Way::at(over, over)].into()
}

fn timestamp(from: Time, to: Option<Time>, view: View<'_>) -> Ways {
    let reached = from.max(view.created);
    if reached <= to.unwrap_or(from) { vec![Way::at(reached, reached)].into() } else { Ways::default() }
}

/// `(:function (REL (current-value 'ATTRIBUTE 'OBJECT) NUMBER))`: returns a way if it holds at this instant.
fn function((attribute, object): (&str, &str), relation: Relation, number: f64, view: View<'_>) -> Ways {
    // The function's value at an instant depended on the knowledge at that time, and cannot be queried later.
    let past = known(&view.question.arrivals, &view.question.lateness, view.now);
    let series = past.variables.iter().find(|each| each.attribute == attribute && each.object == object);
    let newest = series.and_then(|series| series.samples.last()).map(|sample| &sample.value);
    let holds = match (newest, relation) {
        (Some(Value::Number(newest)), _) => Some(numbers(relation, *newest, number)),
        (_, Relation::Equal) => Some(false),
        (_, Relation::Different) => Some(true),
        // Values without an order cannot be compared.
        _ => None,
    };
    match holds {
        Some(true) => vec![Way::now(view)].into(),
        Some(false) => Ways::default(),
        None => Ways { unknown: Some("there is no number to compare".into()), ..Ways::default() },
    }
}

/// Returns combinations of each way of the first with each way of the second that agrees with it and follows it.
fn combined(first: &[Way], second: &[Way], follows: impl Fn(&Way, &Way) -> bool) -> Vec<Way> {
    let mut all = Vec::new();
    for before in first {
        all.extend(second.iter().filter(|next| follows(before, next)).filter_map(|next| before.with(next)));
    }
    all
}

fn passes(test: &Test, way: &Way) -> bool {
    let instant = |(edge, tag): &(Edge, String)| {
        way.tags.get(tag).map(|interval| if *edge == Edge::Start { interval.0 } else { interval.1 })
    };
    match test {
        Test::Apart(relation, left, right, span) => match (instant(left), instant(right)) {
            (Some(left), Some(right)) => numbers(*relation, left - right, *span),
            _ => false,
        },
        Test::Number(relation, name, number) => {
            matches!(way.bound.get(name), Some(Value::Number(value)) if numbers(*relation, *value, *number))
        }
    }
}

/// Returns true if the instant satisfies all tests.
pub(crate) fn instant_fits(at: Time, tests: &[(Relation, Time)]) -> bool {
    tests.iter().all(|(relation, bound)| numbers(*relation, at, *bound))
}
