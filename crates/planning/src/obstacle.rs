//! Obstacles of visits as values: what would have to be different for a target to be visited, by the planner's own arithmetic.
//!
//! A plan states each as the text of [`LeftOut::reason`](apex_model::problem::LeftOut). This is the one definition of these texts:
//! planners write them with `Display`, readers of plans get the figures back with [`Obstacle::parse`]. Other reasons are free text.

use std::fmt;

/// Obstacle of a visit.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacle {
    /// Flying there takes longer than a limit allows.
    Late {
        /// Seconds beyond the limit, as stated: whole seconds below a minute, then whole minutes, rounded up.
        over_s: f64,
        /// The limit.
        limit: TimeLimit,
        /// True if the target cannot be visited as the only one either.
        alone: bool,
    },
    /// A visit earns less than its time costs.
    Score {
        /// Points by which the score would fall.
        loss: f64,
    },
    /// A visit would let the others wait longer.
    ExpectedCost {
        /// Expected cost without the visit.
        without: f64,
        /// Expected cost with it.
        with: f64,
    },
    /// A visit is worth nothing.
    Worthless,
    /// The last time window closes too early.
    Window,
}

/// Limit on the time of a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TimeLimit {
    /// The limit of the flight.
    Flight {
        /// Its name: `endurance`, `the end of the mission`.
        name: String,
        /// Its cause, if the problem states one.
        cause: Option<String>,
    },
    /// The horizon of the plan.
    Horizon,
    /// The time between the other visits.
    OtherVisits,
}

const WINDOW: &str = "its last time window closes before the vehicle can be there";
const WORTHLESS: &str = "is worth nothing: its value, every manoeuvre's quality or its timing is 0";
const SCORE: (&str, &str) = ("would lower the score by ", ": the time it takes costs more than it is worth");
const COST: (&str, &str) =
    ("one visit on the way would raise the expected cost from ", ": the others would wait longer");
const ALONE: &str = ", even alone";
const HORIZON: &str = "the horizon allows";
const OTHER_VISITS: &str = "is left between the others";
const LEAVES: &str = " leaves";
/// Between a limit and its cause.
const CAUSE: &str = ": ";
/// Begin of the reason of a target that could be visited alone.
const BETWEEN: &str = "does not fit between the others: ";

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Obstacle::Late { over_s, limit, alone } => {
                let alone = if *alone { ALONE } else { "" };
                match limit {
                    TimeLimit::Flight { name, cause } => {
                        let cause = cause.as_ref().map_or_else(String::new, |cause| format!("{CAUSE}{cause}"));
                        write!(f, "needs {} more than {name}{LEAVES}{cause}{alone}", spoken(*over_s))
                    }
                    TimeLimit::Horizon => write!(f, "needs {:.0} s more than {HORIZON}{alone}", libm::ceil(*over_s)),
                    TimeLimit::OtherVisits => write!(f, "needs {} more than {OTHER_VISITS}{alone}", spoken(*over_s)),
                }
            }
            Obstacle::Score { loss } => write!(f, "{}{loss:.2}{}", SCORE.0, SCORE.1),
            Obstacle::ExpectedCost { without, with } => write!(f, "{}{without:.4} to {with:.4}{}", COST.0, COST.1),
            Obstacle::Worthless => f.write_str(WORTHLESS),
            Obstacle::Window => f.write_str(WINDOW),
        }
    }
}

impl Obstacle {
    /// Reads the reason of a plan; `None` for a reason that is not an obstacle of this list.
    pub fn parse(reason: &str) -> Option<Obstacle> {
        let reason = reason.strip_prefix(BETWEEN).unwrap_or(reason);
        match reason {
            WORTHLESS => return Some(Obstacle::Worthless),
            WINDOW => return Some(Obstacle::Window),
            _ => {}
        }
        if let Some(loss) = between(reason, SCORE) {
            return Some(Obstacle::Score { loss: loss.parse().ok()? });
        }
        if let Some(figures) = between(reason, COST) {
            let (without, with) = figures.split_once(" to ")?;
            return Some(Obstacle::ExpectedCost { without: without.parse().ok()?, with: with.parse().ok()? });
        }
        let (over, limit) = reason.strip_prefix("needs ")?.split_once(" more than ")?;
        let over_s = seconds_of(over)?;
        let (limit, alone) = limit.strip_suffix(ALONE).map_or((limit, false), |limit| (limit, true));
        let limit = match limit {
            HORIZON => TimeLimit::Horizon,
            OTHER_VISITS => TimeLimit::OtherVisits,
            other => {
                let (name, more) = other.split_once(LEAVES)?;
                let cause = match more {
                    "" => None,
                    more => Some(more.strip_prefix(CAUSE)?.to_owned()),
                };
                TimeLimit::Flight { name: name.to_owned(), cause }
            }
        };
        Some(Obstacle::Late { over_s, limit, alone })
    }
}

fn between<'t>(text: &'t str, (before, after): (&str, &str)) -> Option<&'t str> {
    text.strip_prefix(before)?.strip_suffix(after)
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

/// Reads a span of time as [`spoken`] writes it.
fn seconds_of(text: &str) -> Option<f64> {
    let mut words = text.split(' ');
    let mut sum_s = 0.0;
    while let Some(number) = words.next() {
        let number: u32 = number.parse().ok()?;
        let unit_s = match words.next()? {
            "s" => 1.0,
            "min" => 60.0,
            "h" => 3_600.0,
            _ => return None,
        };
        sum_s += f64::from(number) * unit_s;
    }
    Some(sum_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn obstacles() -> impl Strategy<Value = Obstacle> {
        let names = prop::sample::select(vec!["endurance", "the end of the mission", "the end of the night"]);
        let limit = prop_oneof![
            (names, prop::option::of("[a-z0-9: ]{1,20}"))
                .prop_map(|(name, cause)| TimeLimit::Flight { name: name.to_owned(), cause }),
            Just(TimeLimit::Horizon),
            Just(TimeLimit::OtherVisits),
        ];
        prop_oneof![
            (0.0..200_000.0f64, limit, any::<bool>()).prop_map(|(over_s, limit, alone)| Obstacle::Late {
                over_s,
                limit,
                alone
            }),
            (0.0..1e6f64).prop_map(|loss| Obstacle::Score { loss }),
            (0.0..1e6f64, 0.0..1e6f64).prop_map(|(without, with)| Obstacle::ExpectedCost { without, with }),
            Just(Obstacle::Worthless),
            Just(Obstacle::Window),
        ]
    }

    proptest! {
        #[test]
        fn figures_come_back_as_they_were_stated(obstacle in obstacles()) {
            let text = obstacle.to_string();
            let read = Obstacle::parse(&text).unwrap();
            prop_assert_eq!(read.to_string(), text.clone());
            let between = Obstacle::parse(&format!("does not fit between the others: {text}"));
            prop_assert_eq!(between, Some(read.clone()));
            match (obstacle, read) {
                (Obstacle::Late { over_s: a, limit, alone }, Obstacle::Late { over_s: b, limit: read, alone: still }) => {
                    prop_assert!((limit, alone) == (read, still) && (a - 0.5..a + 60.0).contains(&b), "{a} {b}");
                }
                (Obstacle::Score { loss: a }, Obstacle::Score { loss: b }) => prop_assert!((a - b).abs() <= 0.0051),
                (a, b) => prop_assert_eq!(std::mem::discriminant(&a), std::mem::discriminant(&b)),
            }
        }

        #[test]
        fn any_text_is_read_without_a_panic(text in "(needs |would |does not fit between the others: )?.{0,60}") {
            let _ = Obstacle::parse(&text);
        }
    }

    #[test]
    fn free_texts_are_no_obstacles_of_the_list() {
        for text in [
            "inside restricted area North",
            "needs fuel",
            "needs 3 d more than endurance leaves",
            "no longer a target",
            "",
        ] {
            assert_eq!(Obstacle::parse(text), None, "{text}");
        }
        let battery = "needs 2 min more than the battery leaves: it has 40 min above its reserve of 11 min, even alone";
        let cause = "it has 40 min above its reserve of 11 min".to_owned();
        let expected = TimeLimit::Flight { name: "the battery".to_owned(), cause: Some(cause) };
        assert_eq!(Obstacle::parse(battery), Some(Obstacle::Late { over_s: 120.0, limit: expected, alone: true }));
    }
}
