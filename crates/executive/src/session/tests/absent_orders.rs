//! Absent orders: they keep few instants, and their results are those of all combinations.

use super::conjunctions::kept_anywhere;
use super::point_orders::{results_over, stories};
use super::*;
use crate::state::monitors::monitor::PartKind;

/// Returns the number of instants that the absent order keeps.
fn instants(session: &MonitorSession, id: MonitorId) -> usize {
    let root = &session.watches.get(id.0).unwrap().monitor.as_ref().unwrap().root;
    let PartKind::Absent(absent) = &root.kind else { panic!("{root:?}") };
    let steps = absent.order.iter().flat_map(|order| &order.steps);
    steps.map(|step| step.pending.len() + step.ends.len()).sum()
}

/// Samples come every 0.1 s; the height once, at the beginning, for orders that wait for it.
#[test]
fn an_absent_order_keeps_only_points_that_later_ones_may_follow() {
    for (order, most) in [
        ("(speed uav > 4) (speed uav < 4)", 10),
        ("(speed uav > 4) (speed uav > 3)", 10),
        ("(speed uav > 4) (:delay 5s) (speed uav > 3) (landed)", 60),
        ("(speed uav > 4) (speed uav > 3) (:delay 5s)", 60),
        ("(speed uav > 4) (:delay 1s 5s) (speed uav > 3)", 60),
        ("(height uav >= 0) (speed uav > 3)", 10),
        ("(height uav > 5) (speed uav > 3)", 10),
        (
            "(:measurement x (speed uav) :value (> 4)) (:measurement y (speed uav) :value (> 3))
          :constraint (< (- (start-of ?y) (start-of ?x)) 5s)",
            60,
        ),
    ] {
        let condition = format!("(:absent (:in-order {order}) :for 10s)");
        let (plain, id) = session(&condition, 0.0);
        let mut session = plain.over_a_log();
        session.sample(&of("height"), Value::Integer(0), at(0.0));
        let mut greatest = 0;
        for number in 0..2_000 {
            session.sample(&of("speed"), Value::Real(5.0), Time(number * 100_000_000));
            if number % 100 == 0 {
                session.advance(Time(number * 100_000_000));
                greatest = greatest.max(kept_anywhere(&session, id) + instants(&session, id));
            }
        }
        assert!(greatest <= most, "{condition} keeps {greatest}");
        assert!(session.take_troubles().is_empty(), "{condition}");
    }
}

const ORDERS: [&str; 16] = [
    "(:in-order (a uav > 4) (a uav < 4)",
    "(:in-order (a uav > 4) (b uav < 4)",
    "(:in-order (a uav > 5) (b uav > 5) (a uav < 3)",
    "(:in-order (a uav > 4) (:delay 2s 4s) (a uav < 4)",
    "(:in-order (a uav > 4) (:delay 0s 3s) (b uav > 4)",
    "(:in-order (a uav > 4) (:delay 0s) (b uav > 4) (:delay 0s) (b other > 5)",
    "(:in-order (:delay 3s 9s) (a uav > 3) (:delay 1s 5s) (b other < 3)",
    "(:in-order (a uav > 5) (:delay 1s 4s) (b uav > 5) (:delay 1s 4s) (a uav < 4)",
    "(:in-order (go) (:delay 1s 6s) (a uav < 4) (:delay 1s 6s) (stop)",
    "(:in-order (go) (a uav > 4) (b uav > 4) (:delay 3s) (stop)",
    "(:in-order (stop) (:measurement first (a uav) :value (> 5)) (:delay 2s)",
    "(:in-order (a uav > 5) (:delay 5s) (b uav < 4) (:delay 3s) (:delay 3s)",
    "(:in-order (a uav = 7) (:delay 9s) (go)",
    "(:in-order (a uav = 1) (:delay 0s 2s) (a uav = 2) (:delay 0s 9s) (a uav = 3)",
    "(:in-order (a uav > 6) (a other > 6) (:delay 0s 4s) (b uav > 3) (b other > 3) (:delay 1s)",
    "(:in-order (:delay 20s) (a uav > 5)",
];

/// Orders with constraints on the time between neighbours.
const CONSTRAINED: [&str; 3] = [
    "(:in-order (:measurement x (a uav) :value (> 4)) (:measurement y (b uav) :value (< 4))
      :constraint (< (- (start-of ?y) (end-of ?x)) 3s)",
    "(:in-order (:measurement x (a uav) :value (> 5)) (:delay 1s) (:measurement y (b uav) :value (< 4)) (go)
      :constraint (>= 4s (- (start-of ?y) (start-of ?x)))",
    "(:in-order (go) (:measurement x (a uav) :value (> 4)) (:measurement y (b uav) :value (< 4)) (:delay 2s)
      :constraint (and (< (- (start-of ?y) (end-of ?x)) 6s) (>= (- (start-of ?y) (end-of ?x)) 2s))",
];

/// Keeps the windows without the instants at which they were recognised, each once.
pub(super) fn windows(told: &mut Vec<String>) {
    told.iter_mut().for_each(|result| result.truncate(result.find(" @").unwrap_or(result.len())));
    told.sort();
    told.dedup();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(250))]

    /// A constraint that is always true lets the absence combine all results of the parts.
    #[test]
    fn absences_of_orders_are_those_of_all_combinations(
        story in stories(), number in 0..ORDERS.len() + CONSTRAINED.len(), length in 1i64..12, late: bool, log: bool,
    ) {
        let (order, constraint) = match CONSTRAINED.get(number) {
            Some(order) => (order, ""),
            None => (&ORDERS[number - CONSTRAINED.len()], ":constraint"),
        };
        let mut spans = results_over(&format!("(:absent {order}) :for {length}s)"), &story, late, log);
        let mut tried =
            results_over(&format!("(:absent {order} {constraint} (< 1 2)) :for {length}s)"), &story, late, true);
        if late {
            // A window that late samples withdraw and confirm is reported again, or not if they cannot withdraw it.
            [&mut spans.0, &mut tried.0].into_iter().for_each(windows);
        }
        prop_assert_eq!(spans, tried, "{} for {}s", order, length);
    }
}
