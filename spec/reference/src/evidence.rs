//! Meaning of conditions: all ways in which a condition is true, from everything received, measured and done so far.

use crate::agent::{Agent, Change};
use crate::expression::compare;
use crate::program::{Condition, Span, Term, Time};
use crate::task::{Clause, Level, OUTCOMES, State, Watch};
use crate::value::{Bindings, Value, joined, matches};

/// One way in which a condition is true.
#[derive(Clone)]
pub(crate) struct Proof {
    /// First and last evidence; `None` if no evidence was needed.
    hull: Option<(Time, Time)>,
    /// The instant since which the proof is known.
    known: Time,
    pub(crate) bound: Bindings,
    evidence: Vec<Evidence>,
}

#[derive(Clone, Copy, PartialEq)]
enum Evidence {
    Message(u64),
    Sample(Time, u64),
}

impl Proof {
    fn at(at: Time, evidence: Option<Evidence>) -> Proof {
        Proof { hull: Some((at, at)), known: at, bound: Bindings::new(), evidence: evidence.into_iter().collect() }
    }

    /// Returns the arrivals of its messages.
    pub(crate) fn messages(&self) -> impl Iterator<Item = u64> {
        self.evidence.iter().filter_map(|evidence| match evidence {
            Evidence::Message(arrival) => Some(*arrival),
            Evidence::Sample(..) => None,
        })
    }

    /// Returns the last evidence.
    pub(crate) fn end(&self, now: Time) -> Time {
        self.hull.map_or(now, |hull| hull.1)
    }
}

/// Context in which a clause is judged.
#[derive(Clone, Copy)]
struct Place<'a> {
    task: usize,
    watch: &'a Watch,
    /// True if messages count that arrived before the watch began, while the step was busy.
    missed: bool,
}

impl Agent<'_> {
    /// Returns the first way in which the watched condition is true.
    pub(crate) fn proof(&self, task: usize, watch: &Watch) -> Option<Proof> {
        self.proofs(&watch.condition, Place { task, watch, missed: watch.clause == Clause::Waitfor }).into_iter().next()
    }

    /// Returns the newest arrival in the evidence, which the next instance must not count again.
    pub(crate) fn answered(&self, proof: &Proof) -> Option<u64> {
        let arrival = |evidence: &Evidence| match evidence {
            Evidence::Message(arrival) => Some(*arrival),
            Evidence::Sample(at, arrival) => Some(*arrival).filter(|_| *at == self.now),
        };
        proof.evidence.iter().filter_map(arrival).max()
    }

    fn sees(&self, place: Place<'_>, name: &str) -> Option<Value> {
        self.variable(place.task, place.watch.level, name)
    }

    /// Returns the variable's value for a message or a sample: the value when it is noticed, or when the watch begins if that is later.
    fn saw(&self, place: Place<'_>, name: &str, arrival: u64) -> Option<Value> {
        let owner = self.owner(place.task, place.watch.level, name);
        let later = |change: &&Change| {
            Some(change.task) == owner
                && change.name == name
                && change.number > place.watch.number
                && change.noticed > arrival
        };
        let changed = self.changes.iter().find(later);
        changed.map_or_else(|| self.sees(place, name), |change| Some(change.before.clone()))
    }

    /// Returns all ways, the earliest known first.
    fn proofs(&self, condition: &Condition, place: Place<'_>) -> Vec<Proof> {
        let mut proofs = match condition {
            Condition::Event(pattern) => self.messages_like(pattern, place),
            Condition::Measurement(attribute, object, relation, number) => {
                let fits = |value: &Value, _: u64, _: &mut Bindings| {
                    matches!(compare(*relation, value, &Value::Number(*number)), Ok(true))
                };
                self.samples_of(attribute, object, place, &fits)
            }
            Condition::Sample(attribute, object, name) => {
                let pattern = [Term::Variable(name.clone())];
                let fits = |value: &Value, arrival: u64, bound: &mut Bindings| {
                    matches(&pattern, std::slice::from_ref(value), &|name| self.saw(place, name, arrival), bound)
                };
                self.samples_of(attribute, object, place, &fits)
            }
            Condition::Ended(tag) => self.end_of(tag, place).into_iter().map(|at| Proof::at(at, None)).collect(),
            Condition::State(tag, word) => self.states_of(tag.as_deref(), word, place),
            Condition::Delay(least, most) => {
                let start = place.watch.window.start;
                let over = start + least;
                let reached = over <= self.now && most.is_none_or(|most| most >= *least);
                reached.then(|| Proof::at(over, None)).into_iter().collect()
            }
            Condition::Or(parts) => parts.iter().flat_map(|part| self.proofs(part, place)).collect(),
            Condition::Not(part) => {
                let nothing = self.proofs(part, Place { missed: false, ..place }).is_empty();
                nothing.then(|| Proof::at(self.now, None)).into_iter().collect()
            }
            Condition::And(parts) => self.together(parts, place),
            Condition::InOrder(parts) => {
                self.in_order(parts, place).into_iter().filter(|proof| proof.known <= self.now).collect()
            }
        };
        proofs.sort_by_key(|proof| proof.known);
        proofs
    }

    fn messages_like(&self, pattern: &[Term], place: Place<'_>) -> Vec<Proof> {
        let window = place.watch.window;
        let missed = self.tasks[place.task].missed.as_ref().filter(|_| place.missed);
        let counts = |at: Time, arrival: u64| {
            missed.is_some_and(|missed| missed.contains(&arrival))
                || at >= window.start && window.after.is_none_or(|after| arrival > after)
        };
        let mut proofs = Vec::new();
        for message in self.messages.iter().filter(|message| counts(message.at, message.arrival)) {
            let mut proof = Proof::at(message.at, Some(Evidence::Message(message.arrival)));
            if matches(pattern, &message.words, &|name| self.saw(place, name, message.arrival), &mut proof.bound) {
                proofs.push(proof);
            }
        }
        proofs
    }

    /// Returns samples within the window with a matching object and value. Among several at one time the last one counts.
    fn samples_of(
        &self,
        attribute: &str,
        object: &Term,
        place: Place<'_>,
        fits: &dyn Fn(&Value, u64, &mut Bindings) -> bool,
    ) -> Vec<Proof> {
        let window = place.watch.window;
        let counts = |at: Time, arrival: u64| at >= window.start && window.after.is_none_or(|after| arrival > after);
        let seen: Vec<_> =
            self.samples.iter().filter(|each| each.attribute == attribute && counts(each.at, each.arrival)).collect();
        let mut proofs = Vec::new();
        for (index, sample) in seen.iter().enumerate() {
            let replaced = seen[index + 1..].iter().any(|later| later.object == sample.object && later.at == sample.at);
            let mut proof = Proof::at(sample.at, Some(Evidence::Sample(sample.at, sample.arrival)));
            let named = Value::Word(sample.object.clone());
            let known = |name: &str| self.saw(place, name, sample.arrival);
            let concerns = matches(std::slice::from_ref(object), &[named], &known, &mut proof.bound);
            if !replaced && concerns && fits(&sample.value, sample.arrival, &mut proof.bound) {
                proofs.push(proof);
            }
        }
        proofs
    }

    /// Returns the instant at which the step's task ended, if it is over or has ended since the watch of the clause began. The end of a
    /// repeated instance does not count.
    fn end_of(&self, tag: &str, place: Place<'_>) -> Option<Time> {
        let Some(Value::Task(other)) = self.sees(place, tag) else { return None };
        let again = self.moves.iter().rposition(|each| each.task == other && each.from == State::Terminated);
        let ends = || {
            let moves = self.moves.iter().enumerate();
            let last = moves.filter(|(_, each)| each.task == other && each.to == State::Terminated);
            last.filter(|(number, _)| again.is_none_or(|again| *number > again))
        };
        let since = ends().find(|(number, _)| *number >= place.watch.made);
        let stands = place.watch.standing && self.tasks[other].state == State::Terminated;
        since.or_else(|| ends().next_back().filter(|_| stands)).map(|(_, each)| each.at)
    }

    /// States of the step's task: the state when the watch of the clause began or when the tag first named the task, and the state after
    /// every later change.
    fn states_of(&self, tag: Option<&str>, word: &str, place: Place<'_>) -> Vec<Proof> {
        let other = match tag {
            None => place.task,
            Some(tag) => match self.sees(place, tag) {
                Some(Value::Task(other)) => other,
                _ => return Vec::new(),
            },
        };
        if OUTCOMES.contains(&word) {
            return self.outcomes_of(other, word, place);
        }
        let (made, tagged) = (place.watch.made, self.tasks[other].tagged);
        let (before, since) = self.moves.split_at(made.max(tagged));
        let mut proofs = Vec::new();
        let state = before.iter().rev().find(|each| each.task == other).map_or(State::Pending, |each| each.to);
        let stands = (place.watch.standing || tagged > made) && state.word() == word;
        let since_when = match before.last() {
            Some(last) if tagged > made => last.at,
            _ => place.watch.made_at,
        };
        proofs.extend(stands.then(|| Proof::at(since_when, None)));
        for each in since.iter().filter(|each| each.task == other) {
            let resumed = each.from == State::Interrupted && each.to == State::Ongoing && word == "resumed";
            if each.to.word() == word || resumed {
                proofs.push(Proof::at(each.at, None));
            }
        }
        proofs
    }

    /// Proofs that a task ended finally in this way: since the watch of the clause began, or before if earlier facts count.
    fn outcomes_of(&self, other: usize, word: &str, place: Place<'_>) -> Vec<Proof> {
        let task = &self.tasks[other];
        let ended = task.state == State::Terminated && task.outcome.as_ref().is_some_and(|outcome| outcome.is(word));
        let last = self.moves.iter().enumerate().rfind(|(_, each)| each.task == other);
        let Some((number, last)) = last.filter(|_| ended) else { return Vec::new() };
        if number >= place.watch.made {
            return vec![Proof::at(last.at, None)];
        }
        let stands = place.watch.standing || task.tagged > place.watch.made;
        stands.then(|| Proof::at(place.watch.made_at, None)).into_iter().collect()
    }

    /// Returns the ways of all parts together, in any order; a variable in several parts has the same value in each.
    fn together(&self, parts: &[Condition], place: Place<'_>) -> Vec<Proof> {
        let empty = Proof { hull: None, known: place.watch.window.start, bound: Bindings::new(), evidence: Vec::new() };
        let mut proofs = vec![empty];
        let shared = self.share_variables(parts, place);
        let mut absent = Vec::new();
        for part in parts {
            match part {
                Condition::Not(inner) => {
                    let against = self.proofs(inner, Place { missed: false, ..place });
                    if !shared && !against.is_empty() {
                        return Vec::new();
                    }
                    absent.push(against);
                }
                part => proofs = combined(&proofs, &self.proofs(part, place), |_, _| true),
            }
        }
        proofs.retain(|proof| !absent.iter().flatten().any(|other| joined(&proof.bound, &other.bound).is_some()));
        for proof in &mut proofs {
            if !absent.is_empty() || proof.hull.is_none() {
                proof.known = self.now;
            }
        }
        proofs
    }

    /// Returns true if a variable without a value occurs in several parts.
    fn share_variables(&self, parts: &[Condition], place: Place<'_>) -> bool {
        let mut seen: Vec<String> = Vec::new();
        parts.iter().any(|part| {
            let mut own = Vec::new();
            crate::creation::in_condition(part, &mut own);
            own.retain(|name| self.sees(place, name).is_none());
            let shared = own.iter().any(|name| seen.contains(name));
            seen.extend(own);
            shared
        })
    }

    /// Returns the ways of the parts in sequence, with the delays between them. A final delay may still be in progress.
    fn in_order(&self, parts: &[Condition], place: Place<'_>) -> Vec<Proof> {
        let start = place.watch.window.start;
        let empty = Proof { hull: None, known: start, bound: Bindings::new(), evidence: Vec::new() };
        let mut proofs = vec![empty];
        let mut delay: Option<(Span, Span)> = None;
        for part in parts {
            if let Condition::Delay(least, most) = part {
                // In sequence they add up.
                let (before, before_most) = delay.unwrap_or((0, 0));
                delay = Some((before + least, most.map_or(Span::MAX, |most| most.saturating_add(before_most))));
                continue;
            }
            let follows = |before: &Proof, next: &Proof| {
                let end = before.hull.map_or(start, |hull| hull.1);
                let between = next.hull.map_or(self.now, |hull| hull.0) - end;
                match delay {
                    Some((least, most)) => between >= least && between <= most,
                    None => before.hull.is_none() || between > 0,
                }
            };
            proofs = combined(&proofs, &self.proofs(part, place), follows);
            delay = None;
        }
        if let Some((least, _)) = delay {
            for proof in &mut proofs {
                let over = proof.hull.map_or(start, |hull| hull.1) + least;
                proof.known = proof.known.max(over);
                // If only time has to pass, that is an instant.
                proof.hull = proof.hull.or(Some((over, over)));
            }
        }
        proofs
    }

    /// Returns the instants at which a delay that is watched is over, or may be.
    pub(crate) fn delays_end(&self) -> Vec<Time> {
        let mut ends = Vec::new();
        for (task, watch) in self.living().flat_map(|(id, task)| task.watches.iter().map(move |watch| (id, watch))) {
            self.delays_of(&watch.condition, Place { task, watch, missed: watch.clause == Clause::Waitfor }, &mut ends);
        }
        ends
    }

    fn delays_of(&self, condition: &Condition, place: Place<'_>, ends: &mut Vec<Time>) {
        match condition {
            Condition::Delay(least, _) => ends.push(place.watch.window.start + least),
            Condition::And(parts) | Condition::Or(parts) => {
                parts.iter().for_each(|part| self.delays_of(part, place, ends));
            }
            Condition::Not(part) => self.delays_of(part, place, ends),
            Condition::InOrder(parts) => {
                ends.extend(self.in_order(parts, place).iter().map(|proof| proof.known));
                parts
                    .iter()
                    .filter(|part| !matches!(part, Condition::Delay(..)))
                    .for_each(|part| self.delays_of(part, place, ends));
            }
            _ => {}
        }
    }

    /// Returns the satisfied clauses, in the order in which they are noticed.
    pub(crate) fn noticed(&self, wanted: impl Fn(&Watch) -> bool) -> Vec<(usize, Watch)> {
        let mut noticed: Vec<(usize, Watch)> = Vec::new();
        for (id, task) in self.living() {
            let true_now = task.watches.iter().filter(|watch| wanted(watch) && self.proof(id, watch).is_some());
            noticed.extend(true_now.map(|watch| (id, watch.clone())));
        }
        // Ends come first, so that nothing is started only to be cut; then restarts, suspensions and enablements.
        noticed.sort_by_key(|(id, watch)| (watch.clause, *id, watch.number));
        noticed
    }

    /// Returns true if all variables in the conditions are known to the task.
    pub(crate) fn all_known(&self, id: usize, conditions: &[&Condition]) -> bool {
        let mut names = Vec::new();
        conditions.iter().for_each(|condition| crate::creation::in_condition(condition, &mut names));
        names.iter().all(|name| self.variable(id, Level::Step, name).is_some())
    }
}

/// Returns combinations of each proof of the first with each proof of the second that agrees with it and follows it.
fn combined(first: &[Proof], second: &[Proof], follows: impl Fn(&Proof, &Proof) -> bool) -> Vec<Proof> {
    let mut all = Vec::new();
    for before in first {
        for next in second.iter().filter(|next| follows(before, next)) {
            let Some(bound) = joined(&before.bound, &next.bound) else { continue };
            let hull = match (before.hull, next.hull) {
                (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
                (a, b) => a.or(b),
            };
            let evidence = before.evidence.iter().chain(&next.evidence).copied().collect();
            all.push(Proof { hull, known: before.known.max(next.known), bound, evidence });
        }
    }
    all
}
