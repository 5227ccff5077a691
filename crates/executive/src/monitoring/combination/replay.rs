//! Replay (M&I)
//! What: passes remembered evidence to a part again, instant by instant, in order of arrival: a part that relates results in time would
//! otherwise report other results than one that watched all the time.
//! Runs: when a monitor with an Allen relation or an absence is made, and when a late sample changes its past.
//! Reads: histories, evaluation context.
//! Writes: the part.
//! Bound: O(k log k) for the k samples and messages within the window, and what each of them costs when it arrives.
//! PDL: Allen relations, `:absent`, `:lateness`.
//! Paper: section III, histories.

use crate::expression::EvalContext;
use crate::monitoring::combination::dispatch::{advance, notice_part, wake_of};
use crate::monitoring::combination::interest::collect_interests;
use crate::monitoring::combination::part_results;
use crate::monitoring::numbers::persistence;
use crate::monitoring::part::ConditionFaults;
use crate::monitoring::sampled::Sampled;
use crate::monitoring::stimulus::Stimulus;
use crate::state::histories::history::{Histories, History};
use crate::state::monitors::monitor::{Interest, Part, PartKind, Satisfaction, TimePart};
use apex_model::agent_limits::Limits;
use apex_model::because::Evidence;
use apex_model::event::StateVariable;
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// The evaluation context at an earlier instant; histories contain also what they have learned since.
struct Then<'a> {
    below: &'a dyn EvalContext,
    now: Time,
}

impl EvalContext for Then<'_> {
    fn variable(&self, name: &Symbol) -> Option<Value> {
        self.below.variable(name)
    }
    fn local(&self, name: &Symbol) -> Option<Value> {
        self.below.local(name)
    }
    fn now(&self) -> Time {
        self.now
    }
    fn this_task(&self) -> Option<TaskId> {
        self.below.this_task()
    }
    fn agent_name(&self) -> &Symbol {
        self.below.agent_name()
    }
    fn task_start(&self, task: TaskId) -> Option<Time> {
        self.below.task_start(task)
    }
    fn task_end(&self, task: TaskId) -> Option<Time> {
        self.below.task_end(task)
    }
    fn task_state(&self, task: TaskId) -> Option<TaskState> {
        self.below.task_state(task)
    }
    fn task_outcome(&self, task: TaskId) -> Option<&'static [&'static str]> {
        self.below.task_outcome(task)
    }
    fn task_time_ongoing(&self, task: TaskId) -> Option<Duration> {
        self.below.task_time_ongoing(task)
    }
    fn histories(&self) -> &Histories {
        self.below.histories()
    }
    fn library(&self) -> &Library {
        self.below.library()
    }
    fn host(&self) -> &HostFunctions {
        self.below.host()
    }
    fn limits(&self) -> &Limits {
        self.below.limits()
    }
}

/// Clears the results of `part` and computes them again from remembered evidence. With `newest`, only arrivals up to that number count,
/// because later ones are still to be passed.
pub(crate) fn replay(part: &mut Part, newest: Option<u64>, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
    let stimuli = remembered(part, newest, context);
    forget(part, context, troubles);
    let now = context.now();
    let mut asked = Time::BEGINNING;
    let start = part.window.start;
    if start < now
        && stimuli.first().is_none_or(|(first, ..)| start < *first)
        && matches!(part.kind, PartKind::Absent(_))
    {
        look_then(part, start, context, troubles);
        asked = start;
    }
    for group in stimuli.chunk_by(|(a, ..), (b, ..)| a == b) {
        let Some((at, ..)) = group.first() else { continue };
        let at = (*at).min(now);
        while let Some((wake, _)) = wake_of(part, asked).filter(|(wake, _)| *wake < at) {
            advance(part, &Then { below: context, now: wake }, troubles);
            asked = wake;
        }
        let then = Then { below: context, now: at };
        group.iter().for_each(|(.., stimulus)| notice_part(part, stimulus, &then, troubles));
        // An instant is evaluated after all its arrivals were passed.
        if at < now {
            advance(part, &then, troubles);
            asked = at;
        }
    }
    while let Some((wake, _)) = wake_of(part, asked).filter(|(wake, _)| *wake < now) {
        advance(part, &Then { below: context, now: wake }, troubles);
        asked = wake;
    }
}

/// Returns the arrival number of a late sample if `part` relates results in time: earlier results may have been related wrongly.
pub(crate) fn changes_the_past(part: &Part, stimulus: &Stimulus, context: &dyn EvalContext) -> Option<u64> {
    let Stimulus::Sample { variable, sequence, newest, at, .. } = stimulus else { return None };
    // The present instant is evaluated after all its arrivals were passed.
    let past = *at < context.now();
    let relates = match part.kind {
        PartKind::Allen(_) => past && !newest,
        PartKind::Absent(_) => past && !asks_functions(part) && is_judged_again(part, context),
        _ => false,
    };
    (relates && watches(part, variable) && covers(part, context)).then_some(*sequence)
}

/// Evaluates an absence again from the instant of a late sample, or of the newest known sample, if too little is remembered to evaluate
/// the whole past. Windows that had passed by that instant stay; later ones may be withdrawn.
pub(crate) fn look_at(part: &mut Part, stimulus: &Stimulus, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
    let Stimulus::Sample { at, variable, sequence, .. } = stimulus else { return };
    let PartKind::Absent(leaf) = &mut part.kind else { return };
    if *at >= context.now() || !watches(&leaf.part, variable) || asks_functions(&leaf.part) {
        return;
    }
    let known = newest_known(&leaf.part, *sequence, context).map_or(*at, |newest| newest.max(*at));
    let known = known.max(part.window.start);
    // A sample from before the window does not lie in it, but its value may decide about instants within the window.
    crate::monitoring::combination::absence::take_back(leaf, (*at >= part.window.start).then_some(*at), known);
    let (now, mut looked) = (context.now(), known);
    if known < now {
        look_then(part, known, context, troubles);
        while let Some((wake, _)) = wake_of(part, looked).filter(|(wake, _)| *wake < now) {
            look_then(part, wake, context, troubles);
            looked = wake;
        }
    }
}

/// Returns true if a late sample causes the whole past of an absence to be judged again: if a variable in it is declared with
/// `:lateness`, for which all samples are kept.
fn is_judged_again(part: &Part, context: &dyn EvalContext) -> bool {
    let declared = &context.library().state_variables;
    let is_late =
        |attribute: &Symbol| declared.get(attribute).and_then(crate::monitoring::memory::retention::lateness).is_some();
    let mut again = false;
    collect_interests(part, &mut |interest| {
        again |= match interest {
            Interest::Variable(variable) => is_late(&variable.attribute),
            Interest::Attribute(attribute) => is_late(&attribute),
            _ => false,
        };
    });
    again
}

/// Returns true if the condition calls a function. Its earlier value depends on what was known at that time, so it cannot be evaluated
/// again.
fn asks_functions(part: &Part) -> bool {
    let mut asks = matches!(part.kind, PartKind::Function(_));
    part_results::for_each_inner(part, &mut |inner| asks |= asks_functions(inner));
    asks
}

/// Returns the instant of the newest sample that the part has received, up to this arrival; later arrivals of the same instant are still
/// to be passed.
pub(crate) fn newest_known(part: &Part, told: u64, context: &dyn EvalContext) -> Option<Time> {
    let histories = context.histories();
    let newest =
        |history: &History| history.samples().rev().find(|sample| sample.sequence <= told).map(|newest| newest.at);
    let mut known = None;
    collect_interests(part, &mut |interest| {
        let seen = match interest {
            Interest::Variable(variable) => histories.get(&variable).and_then(newest),
            Interest::Attribute(attribute) => {
                histories.of_attribute(&attribute).filter_map(|(_, history)| newest(history)).max()
            }
            _ => None,
        };
        known = known.max(seen);
    });
    known
}

/// Returns the instant before `now` that decides about an absence and was not evaluated, because a late sample created it.
pub(crate) fn overdue(part: &Part, now: Time) -> Option<Time> {
    match &part.kind {
        PartKind::Absent(leaf)
            if !crate::monitoring::combination::absence::is_done(leaf, crate::monitoring::part::site(part)) =>
        {
            leaf.decides_at
        }
        _ => None,
    }
    .filter(|at| *at < now)
}

/// Evaluates the part in the context of `at`.
pub(crate) fn look_then(part: &mut Part, at: Time, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
    advance(part, &Then { below: context, now: at }, troubles);
}

/// Returns true if `part` watches `variable`.
fn watches(part: &Part, variable: &StateVariable) -> bool {
    let mut watched = false;
    collect_interests(part, &mut |interest| {
        watched |= match interest {
            Interest::Variable(each) => each == *variable,
            Interest::Attribute(attribute) => attribute == variable.attribute,
            _ => false,
        };
    });
    watched
}

/// Returns true if no watched sample was dropped since the start of the part's window, nor one that persists into it.
fn covers(part: &Part, context: &dyn EvalContext) -> bool {
    let (start, histories) = (part.window.start, context.histories());
    let mut covers = true;
    collect_interests(part, &mut |interest| {
        covers &= match interest {
            Interest::Variable(variable) => histories.get(&variable).is_none_or(|history| history.covers(start)),
            Interest::Attribute(attribute) => {
                histories.of_attribute(&attribute).all(|(_, history)| history.covers(start))
            }
            _ => true,
        };
    });
    covers && carries(part, context)
}

/// Returns true if the samples whose values persist into the windows of estimates in the part are still kept. They lie before the span of
/// [`covers`].
fn carries(part: &Part, context: &dyn EvalContext) -> bool {
    let mut all = true;
    if let PartKind::Persisted(leaf) = &part.kind {
        let kept = |history: &History| history.forgotten_until.is_none() || history.before(part.window.start).is_some();
        let histories = context.histories();
        all = match &leaf.variable {
            Some(variable) => histories.get(variable).is_none_or(kept),
            None => histories.of_attribute(&leaf.condition.variable.attribute).all(|(_, history)| kept(history)),
        };
    }
    part_results::for_each_inner(part, &mut |inner| all &= carries(inner, context));
    all
}

/// Samples and messages that concern the part, in order of time and arrival.
fn remembered(part: &Part, newest: Option<u64>, context: &dyn EvalContext) -> Vec<(Time, u64, Stimulus)> {
    let start = first_window(part);
    let histories = context.histories();
    let counts = |sequence: u64| newest.is_none_or(|newest| sequence <= newest);
    // A window that begins after an arrival number needs the arrival numbers of the samples.
    let windowed = part.window.after_sequence.is_some();
    let mut stimuli = Vec::new();
    let mut samples = |variable: &StateVariable, history: &History| {
        for sample in history.between(start, Time::END).filter(|sample| counts(sample.sequence)) {
            let (variable, value) = (variable.clone(), sample.value.clone());
            let sequence = if windowed { sample.sequence } else { history.first_arrival(sample) };
            let at = sample.at;
            stimuli.push((at, sequence, Stimulus::Sample { variable, value, at, sequence, newest: true }));
        }
    };
    let mut interests = Vec::new();
    collect_interests(part, &mut |interest| interests.push(interest));
    interests.sort();
    interests.dedup();
    let mut events = false;
    for interest in &interests {
        match interest {
            Interest::Variable(variable) if interests.contains(&Interest::Attribute(variable.attribute.clone())) => {}
            Interest::Variable(variable) => {
                if let Some(history) = histories.get(variable) {
                    samples(variable, history);
                }
            }
            Interest::Attribute(attribute) => {
                histories.of_attribute(attribute).for_each(|(variable, history)| samples(variable, history));
            }
            Interest::EventHead(_) | Interest::AnyEvent => events = true,
            Interest::Task(_) | Interest::AnyTask | Interest::EveryStep => {}
        }
    }
    if events && !histories.events_cover(start) {
        // Samples may be replaced long after messages are dropped: the results that the part derived from messages are reused.
        results_of_events(part, &mut stimuli);
    } else if events {
        for event in histories.events_from(start).filter(|event| counts(event.sequence)) {
            let (form, at, sequence) = (event.form.clone(), event.at, event.sequence);
            stimuli.push((at, sequence, Stimulus::Event { form, at, sequence }));
        }
    }
    stimuli.sort_by_key(|(at, sequence, _)| (*at, *sequence));
    stimuli
}

/// Collects the messages for which the part has results.
fn results_of_events(part: &Part, stimuli: &mut Vec<(Time, u64, Stimulus)>) {
    let mut add = |results: &[Satisfaction]| {
        for evidence in results.iter().flat_map(|result| result.evidence.iter()) {
            if let Evidence::Event { form, at, sequence } = evidence {
                let stimulus = Stimulus::Event { form: form.clone(), at: *at, sequence: *sequence };
                let told = |(_, _, before): &(Time, u64, Stimulus)| *before == stimulus;
                if !stimuli.iter().any(told) {
                    stimuli.push((*at, *sequence, stimulus));
                }
            }
        }
    };
    match &part.kind {
        PartKind::Event(leaf) => add(&leaf.settled),
        PartKind::Allen(leaf) => leaf.sides.iter().for_each(|side| add(&side.settled)),
        _ => {}
    }
    part_results::for_each_inner(part, &mut |inner| results_of_events(inner, stimuli));
}

/// Returns the earliest instant from which evidence counts in any part.
fn first_window(part: &Part) -> Time {
    let mut start = part.window.start;
    part_results::for_each_inner(part, &mut |inner| start = start.min(first_window(inner)));
    start
}

/// Clears results that rest on samples, messages and time. Ends and states of tasks stay, because no history contains them.
fn forget(part: &mut Part, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
    let site = crate::monitoring::part::site(part);
    let forget_time = |leaf: &mut TimePart| (leaf.span, leaf.reached, leaf.taken) = (None, None, false);
    match &mut part.kind {
        PartKind::Measurement(leaf) => leaf.seen = None,
        PartKind::Persisted(leaf) => persistence::begin_again(leaf, site, context, troubles),
        PartKind::Regression(leaf) => leaf.objects.clear(),
        PartKind::Statistical(leaf) => {
            leaf.settled.clear();
            leaf.objects.clear();
        }
        PartKind::Episode(leaf) => {
            leaf.settled.clear();
            leaf.runs.clear();
        }
        PartKind::Cyclic(leaf) => leaf.begin_again(site, context, troubles),
        PartKind::Event(leaf) => leaf.settled.clear(),
        PartKind::Timestamp(leaf) | PartKind::Delay(leaf) => forget_time(leaf),
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter_mut().for_each(|part| forget(part, context, troubles));
        }
        PartKind::Not(inner) => forget(inner, context, troubles),
        PartKind::Allen(leaf) => {
            crate::monitoring::combination::allen::forget(leaf);
            leaf.parts.iter_mut().for_each(|part| forget(part, context, troubles));
        }
        PartKind::Absent(leaf) => {
            crate::monitoring::combination::absence::forget(leaf, site);
            forget(&mut leaf.part, context, troubles);
        }
        PartKind::TaskEnded(_) | PartKind::TaskState(_) | PartKind::Function(_) => {}
    }
}
