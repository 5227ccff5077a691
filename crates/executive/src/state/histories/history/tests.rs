//! Retention, order, late samples and logs.

use super::*;

fn variable() -> StateVariable {
    StateVariable::new(Symbol::new("altitude"), Value::symbol("uav"))
}

fn sample(at: i64, value: f64) -> Sample {
    Sample { at: Time(at), sequence: 0, value: Value::Real(value) }
}

fn times(histories: &Histories) -> Vec<i64> {
    histories.get(&variable()).unwrap().samples().map(|sample| sample.at.0).collect()
}

#[test]
fn keeps_two_samples_where_no_caller_asks_for_more_and_says_what_it_forgot() {
    let mut histories = Histories::default();
    for at in 0..5 {
        histories.record(&variable(), sample(at, 1.0), Duration::ZERO);
    }
    assert_eq!(times(&histories), [3, 4]);
    let history = histories.get(&variable()).unwrap();
    assert!(history.covers(Time(3)) && !history.covers(Time(2)));
}

#[test]
fn keeps_the_lookback_and_the_value_that_held_at_its_edge() {
    let mut histories = Histories::default();
    histories.require_lookback(&Symbol::new("altitude"), Duration(10));
    for at in [0, 4, 8, 12, 16, 20] {
        histories.record(&variable(), sample(at, 1.0), Duration::ZERO);
    }
    assert_eq!(times(&histories), [8, 12, 16, 20]);
    assert_eq!(histories.get(&variable()).unwrap().at(Time(10)).unwrap().at, Time(8));
    assert_eq!(histories.get(&variable()).unwrap().before(Time(12)).unwrap().at, Time(8));
}

#[test]
fn late_samples_are_inserted_within_lateness_and_kept_aside_beyond() {
    let mut histories = Histories::default();
    histories.require_lookback(&Symbol::new("altitude"), Duration::MAX);
    for at in [0, 10, 20] {
        histories.record(&variable(), sample(at, 1.0), Duration(5));
    }
    assert_eq!(histories.record(&variable(), sample(16, 2.0), Duration(5)).0, Recorded::Inserted);
    assert_eq!(histories.record(&variable(), sample(3, 2.0), Duration(5)).0, Recorded::TooLate);
    assert_eq!(histories.record(&variable(), sample(20, 9.0), Duration(5)).0, Recorded::Replaced);
    assert_eq!(histories.record(&variable(), sample(20, 9.0), Duration(5)).0, Recorded::Repeated);
    assert_eq!(histories.record(&variable(), sample(21, f64::NAN), Duration(5)).0, Recorded::Missing);
    assert_eq!(times(&histories), [0, 10, 16, 20]);
    let history = histories.get(&variable()).unwrap();
    assert_eq!((history.late_count, history.replaced_count, history.missing_count), (1, 1, 1));
    assert_eq!(history.late_samples().count(), 1);
}

#[test]
fn an_open_log_keeps_samples_no_denser_than_it_asks_and_closing_it_lets_them_go() {
    let mut histories = Histories::default();
    let number = histories.open_log(OpenLog {
        variable: variable(),
        spacing: Duration(10),
        time: Duration::MAX,
        count: u64::MAX,
    });
    for at in (0..=60).step_by(5) {
        histories.record(&variable(), sample(at, 1.0), Duration::ZERO);
    }
    assert_eq!(times(&histories), [0, 10, 20, 30, 40, 50, 55, 60]);
    histories.close_log(number);
    histories.record(&variable(), sample(65, 1.0), Duration::ZERO);
    assert_eq!(times(&histories), [60, 65]);
}

#[test]
fn variables_of_an_attribute_are_found_without_the_others() {
    let mut histories = Histories::default();
    for (attribute, object) in [("altitude", 1), ("bank", 1), ("altitude", 2), ("roll", 1)] {
        let variable = StateVariable::new(Symbol::new(attribute), Value::Integer(object));
        histories.record(&variable, sample(0, 1.0), Duration::ZERO);
    }
    let objects: Vec<_> = histories.of_attribute(&Symbol::new("altitude")).map(|(v, _)| v.object.clone()).collect();
    assert_eq!(objects, [Value::Integer(1), Value::Integer(2)]);
}

#[test]
fn events_of_the_newest_instant_are_remembered_in_order_of_arrival() {
    let mut histories = Histories::default();
    for (at, sequence) in [(1, 1), (2, 2), (2, 3)] {
        histories.record_event(Occurrence { at: Time(at), sequence, form: Value::symbol("x") });
    }
    let kept: Vec<_> = histories.events_from(Time(0)).map(|event| event.sequence).collect();
    assert_eq!(kept, [2, 3]);
    assert!(histories.events_cover(Time(2)) && !histories.events_cover(Time(1)));
}

#[test]
fn the_latest_sample_of_any_instant_is_found() {
    for count in 1..7_i64 {
        let mut histories = Histories::default();
        histories.require_lookback(&Symbol::new("altitude"), Duration(1_000));
        for number in 0..count {
            histories.record(&variable(), sample(10 * number, 1.0), Duration::ZERO);
        }
        let times = times(&histories);
        assert_eq!(times.len() as i64, count);
        let history = histories.get(&variable()).unwrap();
        for instant in -5..75 {
            let latest = |early: &dyn Fn(i64) -> bool| times.iter().rev().copied().find(|at| early(*at)).map(Time);
            let at = |sample: Option<&Sample>| sample.map(|sample| sample.at);
            assert_eq!(at(history.at(Time(instant))), latest(&|at| at <= instant), "at {instant} of {count}");
            assert_eq!(at(history.before(Time(instant))), latest(&|at| at < instant), "before {instant} of {count}");
        }
    }
}
