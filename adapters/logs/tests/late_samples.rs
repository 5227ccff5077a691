//! The order of samples that a log has out of order.

use apex_logs::{Ordered, Sampled};
use apex_model::time::Time;
use apex_model::value::Value;

fn passed_on(instants_s: &[f64]) -> Vec<f64> {
    let (mut ordered, mut passed) = (Ordered::default(), Vec::new());
    for at in instants_s {
        ordered.push(Sampled { entry: 0, value: Value::nil(), at: Time::from_seconds(*at) });
        passed.extend(std::iter::from_fn(|| ordered.pop(false)));
    }
    passed.extend(std::iter::from_fn(|| ordered.pop(true)));
    passed.iter().map(|sampled| sampled.at.seconds()).collect()
}

#[test]
fn samples_up_to_a_second_out_of_order_are_sorted() {
    assert_eq!(passed_on(&[0.0, 2.0, 1.0, 1.5, 3.0]), [0.0, 1.0, 1.5, 2.0, 3.0]);
}

/// A sample that comes five seconds late is behind the newest one before it, whether the log ends there or continues.
#[test]
fn the_place_of_a_late_sample_does_not_depend_on_what_follows() {
    assert_eq!(passed_on(&[0.0, 10.0, 5.0]), [0.0, 10.0, 5.0]);
    assert_eq!(passed_on(&[0.0, 10.0, 5.0, 21.0]), [0.0, 10.0, 5.0, 21.0]);
    assert_eq!(passed_on(&[0.0, 10.0, 5.0, 10.5, 9.8]), [0.0, 9.8, 10.0, 5.0, 10.5]);
    assert_eq!(passed_on(&[0.0, 10.0, 20.0, 5.0]), [0.0, 10.0, 20.0, 5.0]);
}
