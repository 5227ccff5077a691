//! The arbiter against a naive twin that applies the rules of `pdl.md` section 9 one by one.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops where it is surprised")]

mod support;

use apex_executive::step;
use apex_model::event::Batch;
use apex_model::task::TaskState;
use proptest::prelude::*;
use std::collections::BTreeSet;
use support::{agent, seconds};

/// A step of the generated program: it needs resources (by bit), may have a priority and a rank, and begins at a time.
#[derive(Clone, Debug)]
struct Claim {
    resources: u8,
    priority: Option<i32>,
    rank: Option<i32>,
    at: u8,
}

fn claims() -> impl Strategy<Value = Vec<Claim>> {
    let claim = (1_u8..8, prop::option::of(0..4_i32), prop::option::of(1..4_i32), 0_u8..4);
    let claim = claim.prop_map(|(resources, priority, rank, at)| Claim { resources, priority, rank, at });
    prop::collection::vec(claim, 1..7)
}

fn program(claims: &[Claim]) -> String {
    let mut text = String::from("(procedure (index (do-domain))");
    let mut primitives = String::new();
    for (number, claim) in claims.iter().enumerate() {
        let priority = claim.priority.map(|each| format!(" (priority {each})")).unwrap_or_default();
        let rank = claim.rank.map(|each| format!(" (rank {each})")).unwrap_or_default();
        let when = format!(" (waitfor (go {}))", claim.at);
        text.push_str(&format!("\n (step t{number} (work {number}){when}{priority}{rank})"));
        let names: Vec<String> =
            (0..3).filter(|bit| claim.resources & (1 << bit) != 0).map(|bit| format!("r{bit}")).collect();
        primitives.push_str(&format!(
            "\n(primitive (index (work {number})) (profile {}) (on-start (command (work))))",
            names.join(" ")
        ));
    }
    text + ")" + &primitives
}

/// Does `a`, a claimant, come before `b`, another claimant, by rank?
fn before_by_rank(a: &Claim, b: &Claim) -> Option<bool> {
    match (a.rank, b.rank) {
        (Some(a), Some(b)) if a != b => Some(a < b),
        _ => None,
    }
}

/// The rules, one by one: a claimant that no other beats goes first; it takes what it needs if it beats every holder in
/// its way; else it takes nothing, and nobody after it may take what it claims. None where rank and priority beat one
/// another in a ring: there the order is arbitrary.
fn twin(
    claims: &[Claim],
    enabled: &BTreeSet<usize>,
    begun: &BTreeSet<usize>,
    holders: &BTreeSet<usize>,
) -> Option<BTreeSet<usize>> {
    let priority = |index: usize| f64::from(claims[index].priority.unwrap_or(0));
    let shares = |a: usize, b: usize| claims[a].resources & claims[b].resources != 0;
    let key = |a: usize| (-priority(a), !begun.contains(&a), a);
    let in_order = |a: usize, b: usize| key(a) < key(b);
    let goes_before = |a: usize, b: usize| before_by_rank(&claims[a], &claims[b]).unwrap_or_else(|| in_order(a, b));
    let mut working = holders.clone();
    let mut waiting: Vec<usize> = enabled.iter().filter(|index| !holders.contains(index)).copied().collect();
    let mut blocked: u8 = 0;
    let mut granted: BTreeSet<usize> = BTreeSet::new();
    while !waiting.is_empty() {
        let beaten = |each: usize| {
            waiting.iter().any(|other| *other != each && shares(*other, each) && goes_before(*other, each))
        };
        let unbeaten = waiting.iter().copied().filter(|each| !beaten(*each));
        let best = unbeaten.reduce(|a, b| if in_order(a, b) { a } else { b })?;
        waiting.retain(|each| *each != best);
        let rivals: Vec<usize> = working.iter().copied().filter(|each| shares(*each, best)).collect();
        let wins = |holder: usize| {
            let by_rank = before_by_rank(&claims[best], &claims[holder]);
            !granted.contains(&holder) && by_rank.unwrap_or(priority(best) > priority(holder) + 0.1)
        };
        if blocked & claims[best].resources == 0 && rivals.iter().all(|rival| wins(*rival)) {
            for rival in rivals {
                working.remove(&rival);
                waiting.push(rival);
            }
            working.insert(best);
            granted.insert(best);
        } else {
            blocked |= claims[best].resources;
        }
    }
    Some(working)
}

/// Who was displaced may take what its winners left over: the twin is asked until it agrees with itself.
fn settled(
    claims: &[Claim],
    enabled: &BTreeSet<usize>,
    begun: &mut BTreeSet<usize>,
    holders: BTreeSet<usize>,
) -> Option<BTreeSet<usize>> {
    let mut holders = holders;
    for _ in 0..20 {
        let next = twin(claims, enabled, begun, &holders)?;
        begun.extend(&next);
        if next == holders {
            return Some(holders);
        }
        holders = next;
    }
    None
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn the_arbiter_agrees_with_its_twin(claims in claims()) {
        let mut agent = agent(&program(&claims));
        step(&mut agent, &Batch { now: seconds(0.0), events: Vec::new() });
        let tasks: Vec<_> = agent.tasks.iter().skip(1).map(|(_, task)| task.id).collect();
        let (mut enabled, mut begun, mut holders) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
        for at in 0..4_u8 {
            let event = support::message(f64::from(at) + 1.0, &format!("(go {at})"));
            step(&mut agent, &Batch { now: event.at, events: vec![event] });
            enabled.extend(claims.iter().enumerate().filter(|(_, claim)| claim.at == at).map(|(index, _)| index));
            let Some(expected) = settled(&claims, &enabled, &mut begun, holders) else { return Err(TestCaseError::reject("a ring")) };
            holders = expected;
            let working = tasks.iter().enumerate().filter(|(_, task)| agent.task(**task).unwrap().state == TaskState::Ongoing);
            prop_assert_eq!(working.map(|(index, _)| index).collect::<BTreeSet<_>>(), holders.clone());
        }
    }
}
