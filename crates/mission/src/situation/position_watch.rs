//! Notes about reported positions: none for minutes, and those that are doubted (`position.rs`).
//!
//! Bound: O(1) per sample.

use super::Note;
use crate::text::plain_duration;
use apex_model::planned::Location;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use serde::{Deserialize, Serialize};

/// Time in the air without an accepted position that is noted: several of the slowest reports of a vehicle.
const SILENCE: Duration = Duration(120_000_000_000);
/// Maximum number of notes of each kind: a receiver may lose and find its fix each second.
const NOTES_MAX: u8 = 10;

/// Reported positions of the vehicle, as far as they are noted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PositionWatch {
    /// The instant of the last accepted position, or of the beginning of the flight; `None` on the ground.
    known_at: Option<Time>,
    /// True if a position was accepted.
    is_known: bool,
    is_silent: bool,
    /// Number of doubted positions since the last accepted one.
    doubted: u32,
    silences: u8,
    doubts: u8,
}

impl PositionWatch {
    /// Takes a reported position; returns the note about it.
    pub(super) fn take(&mut self, at: Time, value: &Value, is_accepted: bool) -> Option<Note> {
        if !is_accepted {
            self.doubted = self.doubted.saturating_add(1);
            let is_noted = self.doubted == 1 && self.doubts < NOTES_MAX;
            self.doubts += u8::from(is_noted);
            return is_noted.then(|| Note { at, text: self.doubt(value) });
        }
        self.is_known = true;
        let doubted = std::mem::take(&mut self.doubted);
        let before = self.known_at.replace(self.known_at.map_or(at, |known| known.max(at)));
        if std::mem::take(&mut self.is_silent) {
            let gap = plain_duration(at - before.unwrap_or(at));
            return Some(Note { at, text: format!("the vehicle reports a position again, after {gap}") });
        }
        (doubted > 1 && self.doubts < NOTES_MAX)
            .then(|| Note { at, text: format!("a reported position is used again, after {doubted} that were doubted") })
    }

    fn doubt(&self, value: &Value) -> String {
        let why = match Location::from_value(value) {
            Some(_) if self.is_known => "the vehicle cannot have flown there since the last position that was used",
            Some(_) => "it is the first one, and far from the mission's start and all targets",
            None => "it does not state a place on or near the Earth",
        };
        let further = if self.doubts == NOTES_MAX { "; further ones are not noted" } else { "" };
        format!("the reported position {value} is doubted: {why}{further}")
    }

    /// Returns the note about a vehicle in the air without a position for minutes.
    pub(super) fn look(&mut self, now: Time, is_on_ground: bool) -> Option<Note> {
        if is_on_ground {
            (self.known_at, self.is_silent) = (None, false);
            return None;
        }
        let known_at = *self.known_at.get_or_insert(now);
        if self.is_silent || now - known_at <= SILENCE || self.silences >= NOTES_MAX {
            return None;
        }
        self.is_silent = true;
        self.silences += 1;
        let further = if self.silences == NOTES_MAX { "; further gaps are not noted" } else { "" };
        let text = format!(
            "the vehicle is in the air and has reported no position that can be used since {known_at}{further}"
        );
        Some(Note { at: now, text })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn s(seconds: i64) -> Time {
        Time(seconds * 1_000_000_000)
    }

    fn place() -> Value {
        Value::list([37.4, -121.1, 60.0].map(Value::Real))
    }

    fn texts(notes: impl IntoIterator<Item = Option<Note>>) -> Vec<(Time, String)> {
        notes.into_iter().flatten().map(|note| (note.at, note.text)).collect()
    }

    #[test]
    fn a_vehicle_without_a_position_for_minutes_is_noted_once_and_when_it_reports_again() {
        let mut watch = PositionWatch::default();
        assert!(texts((0..600).step_by(10).map(|at| watch.look(s(at), true))).is_empty(), "on the ground");
        watch.take(s(600), &place(), true);
        let told = texts((600..1000).step_by(10).map(|at| watch.look(s(at), false)));
        let since = "the vehicle is in the air and has reported no position that can be used since 0:10:00";
        assert_eq!(told, [(s(730), since.to_string())]);
        let again = texts([watch.take(s(1000), &place(), true), watch.take(s(1001), &place(), true)]);
        assert_eq!(again.len(), 1);
        assert!(again[0].1.contains("a position again, after"), "{again:?}");
    }

    #[test]
    fn a_vehicle_that_never_reports_a_position_is_noted_after_its_take_off() {
        let mut watch = PositionWatch::default();
        let told = texts((0..400).step_by(10).map(|at| watch.look(s(at), at < 60)));
        assert_eq!(told.iter().map(|(at, _)| *at).collect::<Vec<_>>(), [s(190)]);
    }

    #[test]
    fn doubted_positions_are_noted_at_their_beginning_and_end() {
        let mut watch = PositionWatch::default();
        let wrong = Value::list([0.0, 0.0, 60.0].map(Value::Real));
        let first = texts([watch.take(s(0), &wrong, false), watch.take(s(0), &place(), true)]);
        assert!(first[0].1.contains("far from the mission's start"), "{first:?}");
        let mut told = texts((0..9).map(|at| watch.take(s(at), &wrong, false)));
        told.extend(texts([watch.take(s(9), &place(), true)]));
        let told: Vec<&str> = told.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told[0].contains("(0.0 0.0 60.0) is doubted: the vehicle cannot have flown there"), "{told:?}");
        assert!(told[1].contains("used again, after 9 that were doubted"), "{told:?}");
        let none = texts([watch.take(s(20), &Value::nil(), false)]);
        assert!(none[0].1.contains("does not state a place on or near the Earth"), "{none:?}");
    }

    #[test]
    fn a_receiver_that_jumps_each_second_makes_few_notes() {
        let mut watch = PositionWatch::default();
        let told = texts((0..1000).map(|at| watch.take(s(at), &place(), at % 2 == 0)));
        assert_eq!(told.len(), usize::from(NOTES_MAX));
        assert!(told.last().unwrap().1.ends_with("further ones are not noted"), "{told:?}");
    }
}
