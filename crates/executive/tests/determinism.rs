//! The same inputs give the same effects, however they are divided into batches, and whatever was stored and restored in between.

mod support;

use apex_executive::{Agent, step};
use apex_model::effect::{DecisionKind, Effect};
use apex_model::event::Batch;
use apex_model::host::HostFunctions;
use apex_model::task::TaskState;
use std::collections::BTreeSet;
use support::{agent, programs, run, run_from, seconds, story};

const UNTIL: f64 = 60.0;

#[test]
fn a_snapshot_continues_as_the_agent_would_have() {
    for (pdl, events) in programs::all() {
        let whole = run(&mut agent(pdl), &events, UNTIL);
        for cut in [0.5, 1.5, 2.5, 4.25, 7.0, 11.0, 21.0] {
            let mut first = agent(pdl);
            let early: Vec<_> = events.iter().filter(|event| event.at <= seconds(cut)).cloned().collect();
            let mut effects = run(&mut first, &early, cut);
            if first.is_finished() {
                continue;
            }
            let bytes = postcard::to_allocvec(&first).unwrap();
            let mut second: Agent = postcard::from_bytes(&bytes).unwrap();
            second.attach(first.library.clone(), HostFunctions::default());
            assert!(first == second, "the snapshot at {cut} s differs from the agent");
            assert_eq!(bytes, postcard::to_allocvec(&second).unwrap(), "storing is not repeatable");
            let late: Vec<_> = events.iter().filter(|event| event.at > seconds(cut)).cloned().collect();
            effects.extend(run_from(&mut second, &late, seconds(cut), UNTIL));
            assert_eq!(story(&effects), story(&whole), "cut at {cut} s");
        }
    }
}

#[test]
fn batches_do_not_matter() {
    for (pdl, events) in programs::all() {
        let expected: Vec<Effect> =
            run(&mut agent(pdl), &events, UNTIL).into_iter().map(|(_, effect)| effect).collect();
        for every in [UNTIL, 13.0, 5.0, 0.7] {
            let mut agent = agent(pdl);
            let mut effects = step(&mut agent, &Batch { now: seconds(0.0), events: Vec::new() });
            let (mut from, mut to) = (0.0, every);
            while from < UNTIL {
                let now = seconds(to.min(UNTIL));
                let part = events.iter().filter(|event| event.at > seconds(from) && event.at <= now);
                effects.extend(step(&mut agent, &Batch { now, events: part.cloned().collect() }));
                (from, to) = (to, to + every);
            }
            assert_eq!(effects, expected, "in batches of {every} s");
        }
    }
}

#[test]
fn every_legal_transition_occurs_in_these_programs() {
    let mut seen = BTreeSet::new();
    for (pdl, events) in programs::all() {
        for (_, effect) in run(&mut agent(pdl), &events, UNTIL) {
            if let Effect::Decided(decision) = effect
                && let DecisionKind::Transition { from, to, .. } = decision.kind
            {
                seen.insert((from, to));
            }
        }
    }
    use TaskState::{Enabled, Interrupted, Ongoing, Pending, Terminated};
    let legal = [
        (Pending, Enabled),
        (Enabled, Ongoing),
        (Ongoing, Interrupted),
        (Interrupted, Ongoing),
        (Ongoing, Pending),
        (Interrupted, Pending),
        (Terminated, Pending),
        (Pending, Terminated),
        (Enabled, Terminated),
        (Ongoing, Terminated),
        (Interrupted, Terminated),
    ];
    let missing: Vec<_> = legal.iter().filter(|pair| !seen.contains(pair)).collect();
    assert!(missing.is_empty(), "never seen: {missing:?}");
    assert_eq!(seen.len(), legal.len(), "seen but not legal: {seen:?}");
}

#[test]
fn decisions_name_their_causes() {
    for (pdl, events) in programs::all() {
        let mut agent = agent(pdl);
        for (_, effect) in run(&mut agent, &events, UNTIL) {
            if let Effect::Decided(decision) = effect {
                assert!(!decision.because.text(&agent.library).is_empty());
            }
        }
    }
}

#[test]
fn nothing_is_left_behind_when_the_application_has_ended() {
    for (pdl, events) in programs::all() {
        let mut agent = agent(pdl);
        run(&mut agent, &events, UNTIL);
        assert!(agent.is_finished());
        assert_eq!((agent.tasks.len(), agent.watches.len(), agent.wakes.len()), (1, 0, 0));
        assert!(agent.commands.is_empty() && agent.requests.is_empty() && agent.questions.is_empty());
        assert!(agent.resources.iter().all(|(_, each)| each.holders.is_empty() && each.waiting.is_empty()));
    }
}
