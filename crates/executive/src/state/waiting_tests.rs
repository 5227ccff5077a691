//! Order of turns and counts of waiting claimants.

use super::*;
use crate::state::queue_place::{QueuePlace, RisingKey};

fn place(task: u64, priority: f64, begun: bool) -> QueueKey {
    QueueKey { priority, rank: None, within: 0.0, begun, order: (Time::BEGINNING, TaskId(0), 0, TaskId(task)) }
}

fn claim(place: QueuePlace, varies: bool) -> Claim {
    Claim::Queued(Box::new(QueuedClaim { place: Some(place), varies, amount: 1.0, ..QueuedClaim::default() }))
}

fn steady(key: QueueKey) -> QueuePlace {
    QueuePlace { steady: Some(key), rising: Vec::new() }
}

#[test]
fn the_line_is_in_order_and_counts_are_kept() {
    let mut waiting = Waiting::default();
    for (task, priority, begun) in [(1, 1.0, false), (2, 3.0, false), (3, 3.0, true), (4, 3.0, false)] {
        waiting.insert(TaskId(task), claim(steady(place(task, priority, begun)), task == 1));
    }
    waiting.insert(TaskId(9), Claim::Apart);
    let queue = |waiting: &Waiting| waiting.in_turn(Time(0), |_, _| 0.0).map(|each| each.task().0).collect::<Vec<_>>();
    assert_eq!(queue(&waiting), [3, 2, 4, 1]);
    assert!(waiting.is_sensitive() && waiting.order().is_none());
    waiting.insert(TaskId(1), claim(steady(place(1, 5.0, false)), false));
    assert!(waiting.remove(TaskId(9)) && !waiting.remove(TaskId(9)));
    assert_eq!(queue(&waiting), [1, 3, 2, 4]);
    assert!(!waiting.is_sensitive() && waiting.order() == Some(TurnOrder::Plain));
}

#[test]
fn urgent_claimants_stand_by_what_they_are_worth_now() {
    let mut waiting = Waiting::default();
    let rising = |task: u64, importance: f64, due: i64| {
        let order = (Time::BEGINNING, TaskId(0), 0, TaskId(task));
        let key = RisingKey { importance, due: Time(due * 1_000_000_000), begun: false, order };
        QueuePlace { steady: None, rising: vec![key] }
    };
    // The priority is the importance less the remaining time.
    let worth =
        |now: i64| move |importance: f64, due: Time| importance - ((due.0 - now * 1_000_000_000) as f64 / 1e9).max(0.5);
    for (task, importance, due) in [(4, 9.0, 20), (3, 9.0, 10), (2, 5.0, 4), (1, 5.0, 4)] {
        waiting.insert(TaskId(task), claim(rising(task, importance, due), false));
    }
    waiting.insert(TaskId(5), claim(steady(place(5, 2.0, false)), false));
    let queue = |waiting: &Waiting, now: i64| {
        let turns = waiting.in_turn(Time(now * 1_000_000_000), worth(now));
        turns.map(|each| each.task().0).collect::<Vec<_>>()
    };
    assert_eq!(queue(&waiting, 0), [5, 1, 2, 3, 4]);
    assert_eq!(queue(&waiting, 9), [3, 1, 2, 5, 4]);
    waiting.settle(Time(9_000_000_000));
    assert_eq!(queue(&waiting, 19), [3, 4, 1, 2, 5]);
    waiting.remove(TaskId(1));
    waiting.remove(TaskId(3));
    assert_eq!(queue(&waiting, 19), [4, 2, 5]);
}
