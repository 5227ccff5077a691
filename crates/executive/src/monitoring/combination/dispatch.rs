//! Dispatch (M&I)
//! What: passes stimuli, the passing of time and queries for wakes to the service of each kind of part.
//! Runs: when a monitor notices something or is judged.
//! Reads: the monitor's tree, evaluation context.
//! Writes: the monitor's tree.
//! Bound: linear in the condition, in addition to what the services state.
//! PDL: all conditions.
//! Paper: section III, condition monitoring.

use crate::expression::EvalContext;
use crate::monitoring::basic::time_conditions::{self, TimeForm};
use crate::monitoring::basic::{event, function, measurement, task_state};
use crate::monitoring::combination::{absence, allen, replay};
use crate::monitoring::episodes::episode;
use crate::monitoring::numbers::persistence;
use crate::monitoring::part::{ConditionFaults, noting_limits, site};
use crate::monitoring::sampled;
use crate::monitoring::samples::SampleView;
use crate::monitoring::stimulus::Stimulus;
use crate::monitoring::wake::WakeReason;
use crate::state::monitors::monitor::{Part, PartKind};
use apex_model::time::Time;

/// Passes a stimulus to the part.
pub(crate) fn notice_part(
    part: &mut Part,
    stimulus: &Stimulus,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    noting_limits(part, troubles, |part, troubles| notice_kind(part, stimulus, context, troubles));
}

fn notice_kind(part: &mut Part, stimulus: &Stimulus, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
    let site = site(part);
    if let Some(sequence) = replay::changes_the_past(part, stimulus, context) {
        replay::replay(part, Some(sequence), context, troubles);
        return;
    }
    if let Stimulus::Sample { variable, value, at, sequence, newest } = stimulus {
        let sample = SampleView { variable, value, at: *at, sequence: *sequence };
        notice_sample(part, sample, *newest, context, troubles);
    }
    match (&mut part.kind, stimulus) {
        (PartKind::Event(leaf), Stimulus::Event { form, at, sequence }) => {
            event::notice(leaf, site, form, *at, *sequence, context, troubles);
        }
        (PartKind::TaskEnded(leaf), Stimulus::TaskEnded { task, at, .. }) => task_state::notice_ended(leaf, *task, *at),
        (PartKind::TaskState(leaf), Stimulus::TaskState { task, from, state, at, .. }) => {
            task_state::notice_state(leaf, site, (*task, *from, *state, *at), context, troubles);
        }
        (PartKind::TaskState(leaf), Stimulus::TaskEnded { task, outcome, at, .. }) => {
            task_state::notice_outcome(leaf, site, (*task, outcome, *at), context, troubles);
        }
        (PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite), _) => {
            composite.parts.iter_mut().for_each(|part| notice_part(part, stimulus, context, troubles));
        }
        (PartKind::Not(inner), _) => notice_part(inner, stimulus, context, troubles),
        (PartKind::Allen(leaf), _) if !allen::is_done(leaf, site) => {
            if let Stimulus::Sample { variable, at, newest: false, .. } = stimulus {
                allen::replace(leaf, variable, *at);
            }
            leaf.parts.iter_mut().for_each(|part| notice_part(part, stimulus, context, troubles));
        }
        // Also if no further result is needed: a late sample may withdraw a found result.
        (PartKind::Absent(leaf), _) => {
            notice_part(&mut leaf.part, stimulus, context, troubles);
            replay::look_at(part, stimulus, context, troubles);
        }
        _ => {}
    }
}

/// Passes a sample to a part that watches a state variable.
fn notice_sample(
    part: &mut Part,
    sample: SampleView<'_>,
    newest: bool,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    let site = site(part);
    match &mut part.kind {
        PartKind::Measurement(leaf) => measurement::notice(leaf, site, sample, newest, context, troubles),
        PartKind::Episode(leaf) => sampled::notice(&mut **leaf, site, sample, context, troubles),
        PartKind::Persisted(leaf) => persistence::notice(leaf, site, sample, context, troubles),
        PartKind::Regression(leaf) => sampled::notice(&mut **leaf, site, sample, context, troubles),
        PartKind::Statistical(leaf) => sampled::notice(&mut **leaf, site, sample, context, troubles),
        PartKind::Cyclic(leaf) => sampled::notice(&mut **leaf, site, sample, context, troubles),
        _ => {}
    }
}

/// Lets parts that depend on time or on other tasks catch up with the present.
pub(crate) fn advance(part: &mut Part, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
    noting_limits(part, troubles, |part, troubles| advance_kind(part, context, troubles));
}

fn advance_kind(part: &mut Part, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
    let site = site(part);
    while let Some(at) = replay::overdue(part, context.now()) {
        replay::look_then(part, at, context, troubles);
    }
    match &mut part.kind {
        PartKind::TaskEnded(leaf) => task_state::advance_ended(leaf, context),
        PartKind::TaskState(leaf) => task_state::advance_state(leaf, site, context, troubles),
        PartKind::Timestamp(leaf) => time_conditions::advance(leaf, TimeForm::Timestamp, site, context),
        PartKind::Delay(leaf) => time_conditions::advance(leaf, TimeForm::Delay, site, context),
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter_mut().for_each(|part| advance(part, context, troubles));
        }
        PartKind::Not(inner) => advance(inner, context, troubles),
        PartKind::Allen(leaf) => {
            leaf.parts.iter_mut().for_each(|part| advance(part, context, troubles));
            allen::advance(leaf, site, part.tag.as_ref(), context, troubles);
        }
        PartKind::Absent(leaf) => {
            advance(&mut leaf.part, context, troubles);
            absence::advance(leaf, site, context, troubles);
        }
        PartKind::Function(leaf) => function::advance(leaf, context, troubles),
        PartKind::Measurement(_)
        | PartKind::Episode(_)
        | PartKind::Persisted(_)
        | PartKind::Regression(_)
        | PartKind::Statistical(_)
        | PartKind::Cyclic(_)
        | PartKind::Event(_) => {}
    }
}

pub(crate) fn wake_of(part: &Part, after: Time) -> Option<(Time, WakeReason)> {
    match &part.kind {
        PartKind::Episode(leaf) => episode::next_wake(leaf, site(part), after),
        PartKind::Timestamp(leaf) => time_conditions::next_wake(leaf, TimeForm::Timestamp, after),
        PartKind::Delay(leaf) => time_conditions::next_wake(leaf, TimeForm::Delay, after),
        PartKind::And(composite) | PartKind::Or(composite) => {
            composite.parts.iter().filter_map(|part| wake_of(part, after)).min()
        }
        // A delay between ordered parts does not name an instant.
        PartKind::InOrder(composite) => composite
            .parts
            .iter()
            .filter(|part| !matches!(part.kind, PartKind::Delay(_)))
            .filter_map(|part| wake_of(part, after))
            .min(),
        PartKind::Not(inner) => wake_of(inner, after),
        PartKind::Allen(leaf) if allen::is_done(leaf, site(part)) => None,
        PartKind::Allen(leaf) => {
            let decided = leaf.decides_at.filter(|at| *at > after).map(|at| (at, WakeReason::RelationDecided));
            leaf.parts.iter().filter_map(|part| wake_of(part, after)).chain(decided).min()
        }
        PartKind::Absent(leaf) if absence::is_done(leaf, site(part)) => None,
        PartKind::Absent(leaf) => {
            let over = leaf.decides_at.filter(|at| *at > after).map(|at| (at, WakeReason::AbsenceOver(leaf.length)));
            wake_of(&leaf.part, after).into_iter().chain(over).min()
        }
        PartKind::Function(_) => None,
        // The last verdict determined when these become true.
        PartKind::Persisted(_) | PartKind::Regression(_) | PartKind::Statistical(_) => None,
        PartKind::Measurement(_)
        | PartKind::Cyclic(_)
        | PartKind::Event(_)
        | PartKind::TaskEnded(_)
        | PartKind::TaskState(_) => None,
    }
}
