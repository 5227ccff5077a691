//! Validity of travel times given as numbers.

use apex_model::problem::{LaterTimes, TravelTimes, UNREACHABLE_S};

/// Maximum number of departures for which times may be given: a day in steps of ten minutes, with reserve around each change of the wind.
const DEPARTURES_MAX: usize = 256;
/// A later departure may arrive earlier by this much: rounding of given times.
const OVERTAKEN_S_MAX: f64 = 1e-3;

/// Rejects times that do not fit `count` targets, are not durations, or let a later departure arrive earlier.
pub(super) fn times(travel: &TravelTimes, count: usize, with_base: bool) -> Result<(), String> {
    let TravelTimes { from_start_s, between_s, to_base_s, later } = travel;
    table((from_start_s, between_s, to_base_s), count, with_base)?;
    if later.len() > DEPARTURES_MAX {
        return Err(format!("there are travel times for {} departures; give {DEPARTURES_MAX} at most", later.len()));
    }
    let mut before = DepartureTable { depart_s: 0.0, from_start_s, between_s, to_base_s };
    for times in later {
        let LaterTimes { depart_s, from_start_s, between_s, to_base_s } = times;
        if !depart_s.is_finite() || *depart_s <= before.depart_s {
            return Err(format!(
                "travel times for leaving at {depart_s} s follow those for {} s; give later departures by rising time, the first after 0",
                before.depart_s
            ));
        }
        table((from_start_s, between_s, to_base_s), count, with_base)?;
        let next = DepartureTable { depart_s: *depart_s, from_start_s, between_s, to_base_s };
        overtaking(&before, &next)?;
        before = next;
    }
    Ok(())
}

fn table(
    (from_start_s, between_s, to_base_s): (&Vec<f64>, &Vec<Vec<f64>>, &Vec<f64>),
    count: usize,
    with_base: bool,
) -> Result<(), String> {
    let square = between_s.len() == count && between_s.iter().all(|row| row.len() == count);
    if from_start_s.len() != count || !square || (with_base && to_base_s.len() != count) {
        return Err(format!("the travel times do not fit {count} targets: give one row and one column per target"));
    }
    // Row by row and without leaving early: a thousand targets have a million times.
    let sound = |times: &Vec<f64>| times.iter().fold(true, |sound, time_s| sound & (*time_s >= 0.0));
    if ![from_start_s, to_base_s].into_iter().chain(between_s).all(sound) {
        return Err("a travel time is negative or not a number".to_string());
    }
    Ok(())
}

/// The times of one departure.
struct DepartureTable<'a> {
    depart_s: f64,
    from_start_s: &'a Vec<f64>,
    between_s: &'a Vec<Vec<f64>>,
    to_base_s: &'a Vec<f64>,
}

impl DepartureTable<'_> {
    fn times(&self) -> impl Iterator<Item = f64> {
        // The base is last: its times may be missing if no return is required.
        self.from_start_s.iter().chain(self.between_s.iter().flatten()).chain(self.to_base_s).copied()
    }
}

fn overtaking(before: &DepartureTable<'_>, next: &DepartureTable<'_>) -> Result<(), String> {
    let passed_s = next.depart_s - before.depart_s;
    let mut pairs = before.times().zip(next.times());
    let early = |(early_s, late_s): &(f64, f64)| {
        early_s.max(*late_s) < UNREACHABLE_S && early_s - late_s > passed_s + OVERTAKEN_S_MAX
    };
    match pairs.find(early) {
        Some((early_s, late_s)) => Err(format!(
            "a path takes {early_s} s for a departure at {} s and {late_s} s for a departure at {} s, which would arrive earlier; such a path includes waiting",
            before.depart_s, next.depart_s
        )),
        None => Ok(()),
    }
}
