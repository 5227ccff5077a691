//! Reasons for which a plan leaves targets out: the texts of obstacles, and other reasons as text alone.
//!
//! This is the one definition of these texts. A program reads [`LeftOut::obstacle`], never the text, which rounds its figures.

use apex_model::problem::{LeftOut, Obstacle, TimeLimit};

/// Reason for which a target is not visited.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOutReason {
    /// The reason for operators.
    pub text: String,
    /// The same as a value; `None` if it is not one of the list.
    pub obstacle: Option<Obstacle>,
}

impl LeftOutReason {
    /// Returns the target as left out for this reason.
    pub fn of(self, target: String) -> LeftOut {
        LeftOut { target, reason: self.text, obstacle: self.obstacle }
    }

    /// Replaces the reason of a target that is left out.
    pub fn replace_in(self, left_out: &mut LeftOut) {
        (left_out.reason, left_out.obstacle) = (self.text, self.obstacle);
    }

    /// Returns the reason with a text before its own.
    #[must_use]
    pub fn after(self, before: &str) -> LeftOutReason {
        LeftOutReason { text: format!("{before}{}", self.text), obstacle: self.obstacle }
    }
}

impl From<Obstacle> for LeftOutReason {
    fn from(obstacle: Obstacle) -> LeftOutReason {
        LeftOutReason { text: text(&obstacle), obstacle: Some(obstacle) }
    }
}

impl From<String> for LeftOutReason {
    fn from(text: String) -> LeftOutReason {
        LeftOutReason { text, obstacle: None }
    }
}

impl From<&str> for LeftOutReason {
    fn from(text: &str) -> LeftOutReason {
        LeftOutReason::from(text.to_string())
    }
}

/// Returns the text of an obstacle.
fn text(obstacle: &Obstacle) -> String {
    match obstacle {
        Obstacle::Late { over_s, limit, alone } => {
            let alone = if *alone { ", even alone" } else { "" };
            match limit {
                TimeLimit::Flight { name, cause, .. } => {
                    let cause = cause.as_ref().map_or_else(String::new, |cause| format!(": {cause}"));
                    format!("needs {} more than {name} leaves{cause}{alone}", spoken(*over_s))
                }
                TimeLimit::Horizon => format!("needs {:.0} s more than the horizon allows{alone}", libm::ceil(*over_s)),
                TimeLimit::OtherVisits => {
                    format!("needs {} more than is left between the others{alone}", spoken(*over_s))
                }
            }
        }
        Obstacle::Score { loss } => {
            format!("would lower the score by {loss:.2}: the time it takes costs more than it is worth")
        }
        Obstacle::ExpectedCost { without, with } => format!(
            "one visit on the way would raise the expected cost from {without:.4} to {with:.4}: the others would wait longer"
        ),
        Obstacle::Worthless => "is worth nothing: its value, every manoeuvre's quality or its timing is 0".to_string(),
        Obstacle::Window => "its last time window closes before the vehicle can be there".to_string(),
    }
}

/// Formats a span of time as in speech, rounded up: `41 min`, `3 h 5 min`, `20 s`.
pub fn spoken(seconds: f64) -> String {
    let minutes = libm::ceil(seconds / 60.0);
    if seconds < 60.0 {
        format!("{:.0} s", libm::ceil(seconds))
    } else if minutes < 60.0 {
        format!("{minutes:.0} min")
    } else {
        format!("{:.0} h {:.0} min", libm::floor(minutes / 60.0), minutes - 60.0 * libm::floor(minutes / 60.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(name: &str, cause: Option<&str>) -> TimeLimit {
        TimeLimit::Flight { name: name.to_string(), cause: cause.map(str::to_string), is_energy: true }
    }

    #[test]
    fn each_obstacle_has_its_text_with_figures_rounded_for_reading() {
        let late = |over_s, limit, alone| Obstacle::Late { over_s, limit, alone };
        let battery = limit("the battery", Some("it has 40 min above its reserve of 11 min"));
        for (obstacle, expected) in [
            (
                late(119.2, battery, true),
                "needs 2 min more than the battery leaves: it has 40 min above its reserve of 11 min, even alone",
            ),
            (late(11_041.0, limit("endurance", None), false), "needs 3 h 5 min more than endurance leaves"),
            (late(19.2, limit("endurance", None), false), "needs 20 s more than endurance leaves"),
            (late(119.2, TimeLimit::Horizon, false), "needs 120 s more than the horizon allows"),
            (late(61.0, TimeLimit::OtherVisits, false), "needs 2 min more than is left between the others"),
            (
                Obstacle::Score { loss: 0.126 },
                "would lower the score by 0.13: the time it takes costs more than it is worth",
            ),
            (
                Obstacle::ExpectedCost { without: 1.0, with: 2.000_04 },
                "one visit on the way would raise the expected cost from 1.0000 to 2.0000: the others would wait longer",
            ),
            (Obstacle::Worthless, "is worth nothing: its value, every manoeuvre's quality or its timing is 0"),
            (Obstacle::Window, "its last time window closes before the vehicle can be there"),
        ] {
            let left_out = LeftOutReason::from(obstacle.clone()).of("barn".to_string());
            assert_eq!((left_out.reason.as_str(), left_out.obstacle), (expected, Some(obstacle)));
        }
    }
}
