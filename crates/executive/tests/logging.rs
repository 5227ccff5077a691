//! Tests of `(log ..)`: the samples that it keeps of a variable without other demand, and the reports about unusual samples.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

mod support;

use apex_executive::state::histories::history::History;
use apex_executive::{Agent, step};
use apex_model::effect::{DecisionKind, Effect};
use apex_model::event::{Batch, Event, StateVariable};
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use support::{agent, message, run_from, sample, seconds};

/// Returns an agent that logs the roll angle, declared as `declared`, with `limits`, until it is stopped.
fn logging(declared: &str, limits: &str) -> Agent {
    agent(&format!(
        "(state-variable (roll ?aircraft) :unit deg {declared})
         (procedure (index (do-domain))
           (step watch (watch))
           (step finish (terminate) (waitfor (bye))))
         (procedure (index (watch)) (log ((roll uav) {limits})) (step rest (terminate) (waitfor (stop))))"
    ))
}

fn history(agent: &Agent) -> &History {
    agent.histories.get(&StateVariable::new(Symbol::new("roll"), Value::symbol("uav"))).unwrap()
}

/// Returns the instants kept, in tenths of a second.
fn kept(agent: &Agent) -> Vec<i64> {
    history(agent).samples().map(|sample| sample.at.0 / 100_000_000).collect()
}

fn trouble(effect: &Effect) -> Option<String> {
    match effect {
        Effect::Decided(decision) => match &decision.kind {
            DecisionKind::Trouble { message } => Some(message.clone()),
            _ => None,
        },
        _ => None,
    }
}

/// Samples every half second from `from` on.
fn every_half_second(from: f64, count: u32) -> Vec<Event> {
    (0..count).map(|index| sample(from + f64::from(index) * 0.5, "(roll uav)", &index.to_string())).collect()
}

fn after(limits: &str) -> Agent {
    let mut agent = logging("", limits);
    run_from(&mut agent, &every_half_second(1.0, 19), seconds(0.0), 10.0);
    agent
}

#[test]
fn without_limits_all_is_kept() {
    let all: Vec<i64> = (0..19).map(|index| 10 + 5 * index).collect();
    assert_eq!(kept(&after("")), all);
    assert_eq!(history(&after("")).forgotten_until, None);
}

#[test]
fn a_frequency_limit_keeps_no_denser_than_it_says_and_the_two_newest() {
    let agent = after(":frequency-limit 2s");
    assert_eq!(kept(&agent), [10, 30, 50, 70, 90, 95, 100], "two seconds apart, except for the two newest");
    // Samples left out by thinning were not requested: the history does not count them as dropped.
    assert_eq!(history(&agent).forgotten_until, None);
}

#[test]
fn a_time_limit_keeps_what_is_young_enough() {
    let agent = after(":time-limit 3s");
    assert_eq!(kept(&agent), [70, 75, 80, 85, 90, 95, 100]);
    assert_eq!(history(&agent).forgotten_until, Some(seconds(6.5)), "what is older is unknown, not absent");
}

#[test]
fn a_count_limit_keeps_so_many() {
    let agent = after(":count-limit 4");
    assert_eq!(kept(&agent), [85, 90, 95, 100]);
    assert_eq!(history(&agent).forgotten_until, Some(seconds(8.0)));
}

#[test]
fn limits_of_one_policy_count_together_and_go_with_it() {
    let mut agent = after(":frequency-limit 1s :count-limit 4");
    assert_eq!(kept(&agent), [80, 90, 95, 100]);
    run_from(&mut agent, &[message(10.5, "(stop)")], seconds(10.0), 11.0);
    run_from(&mut agent, &every_half_second(11.0, 2), seconds(11.0), 12.0);
    assert_eq!(kept(&agent), [110, 115], "the policy is closed: what conditions need is left");
}

#[test]
fn odd_samples_are_counted_and_reported_and_late_ones_can_be_seen() {
    let mut agent = logging(":lateness 2s", "");
    let events = [
        sample(1.0, "(roll uav)", "1"),
        sample(5.0, "(roll uav)", "5"),
        sample(5.0, "(roll uav)", "6"),
        sample(5.0, "(roll uav)", "6"),
    ];
    run_from(&mut agent, &events, seconds(0.0), 6.0);
    // Samples of 4 s and 2 s that arrive at 7 s.
    let late = [sample(4.0, "(roll uav)", "4"), sample(2.0, "(roll uav)", "2"), sample(7.0, "(roll uav)", "3kg")];
    let events = late.into_iter().zip(10..).map(|(event, sequence)| Event { sequence, ..event }).collect();
    let told = step(&mut agent, &Batch { now: seconds(7.0), events });
    let troubles: Vec<String> = told.iter().filter_map(trouble).collect();
    assert!(troubles[0].contains("at 2s came too late and is kept aside"), "{troubles:?}");
    assert!(
        troubles[1].contains("the sample 3kg (mass) of (roll uav) was refused: it is declared in deg"),
        "{troubles:?}"
    );
    let history = history(&agent);
    assert_eq!(kept(&agent), [10, 40, 50], "the late one is in order, the one that is too late is not there");
    assert_eq!((history.replaced_count, history.late_count), (1, 1));
    let aside: Vec<_> = history.late_samples().map(|sample| sample.at).collect();
    assert_eq!(aside, [seconds(2.0)], "it is kept aside");
}

/// Returns the kept messages that begin with `seen`, in whole seconds, while a procedure that logs them is ongoing and after its end;
/// there is no other demand.
fn messages_kept(limits: &str) -> [Option<Vec<i64>>; 2] {
    let mut agent = agent(&format!(
        "(procedure (index (do-domain))
           (step watch (watch))
           (step finish (terminate) (waitfor (bye))))
         (procedure (index (watch)) (log ((:events seen) {limits})) (step rest (terminate) (waitfor (stop))))"
    ));
    let seconds_of = |agent: &Agent, from: f64| {
        let kept = agent.histories.events_of(&Symbol::new("seen"), seconds(from), seconds(100.0))?;
        Some(kept.iter().map(|event| event.at.0 / 1_000_000_000).collect())
    };
    let said = |at: f64| [message(at, "(seen site)"), message(at, "(heard site)")];
    let events: Vec<Event> = [1.0, 2.0, 3.0, 6.0, 7.0, 12.0].into_iter().flat_map(said).collect();
    run_from(&mut agent, &events, seconds(0.0), 12.0);
    let during = seconds_of(&agent, 6.0);
    run_from(&mut agent, &[message(13.0, "(stop)"), message(14.0, "(noise)")], seconds(13.0), 14.0);
    [during, seconds_of(&agent, 6.0)]
}

#[test]
fn a_log_keeps_messages_by_their_first_word_while_its_procedure_is_at_work() {
    assert_eq!(messages_kept(""), [Some(vec![6, 7, 12]), None]);
    assert_eq!(messages_kept(":time-limit 6s"), [Some(vec![6, 7, 12]), None]);
    assert_eq!(messages_kept(":frequency-limit 3s"), [Some(vec![6, 12]), None]);
    // Dropped as too many or too old is unknown, not absent.
    assert_eq!(messages_kept(":count-limit 2"), [None, None]);
    assert_eq!(messages_kept(":time-limit 5s"), [None, None]);
}
