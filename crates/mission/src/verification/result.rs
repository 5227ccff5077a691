//! Findings of the check of a flight, and their text.

use crate::text::plain_duration;
use apex_model::problem::Position;
use apex_model::time::Time;
use serde::Serialize;
use std::fmt;

/// Violation by a flight.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Violation {
    /// Inside this restricted zone while the zone was active.
    Inside(String),
    /// Outside of every permitted zone that was active.
    OutsidePermitted,
    /// Too near to the ground, without take-off, landing or climb.
    NearGround,
    /// The flight ended in the ground.
    Crashed,
    /// Farther from every landing place than the mission allows.
    BeyondLandingDistance,
}

impl Violation {
    /// Returns the requirement by its name in `(requirement-broken NAMES WHY)`.
    pub fn requirement(&self) -> &str {
        match self {
            Violation::Inside(zone) => zone,
            Violation::OutsidePermitted => "permitted area",
            Violation::NearGround | Violation::Crashed => "ground",
            Violation::BeyondLandingDistance => "landing distance",
        }
    }
}

/// One position at which a requirement was violated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Instant.
    pub t_s: f64,
    /// Position.
    pub position: Position,
    /// Altitude above mean sea level.
    pub altitude_m: f64,
    /// Kind.
    pub violation: Violation,
}

/// Report of a flight that it has to violate requirements.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportedViolation {
    /// Instant.
    pub t_s: f64,
    /// The requirements, by their names in `(requirement-broken NAMES WHY)`.
    pub names: Vec<String>,
    /// Reason.
    pub why: String,
}

impl ReportedViolation {
    /// Returns true if the report names the requirement of a violation.
    pub fn is_about(&self, violation: &Violation) -> bool {
        self.names.iter().any(|name| name == violation.requirement())
    }
}

/// Findings of the check of a flight.
#[derive(Clone, Debug, Default, Serialize)]
pub struct CheckResult {
    /// Steps of the record.
    pub steps: u64,
    /// Positions in the air that were checked.
    pub positions: u64,
    /// Number of these positions that count as in the air by commands and positions: the vehicle reports neither `on-ground` nor
    /// `flight-phase`.
    pub air_derived: u64,
    /// Number of these positions without a height over ground, which are not compared with the ground.
    pub height_unknown: u64,
    /// Number of these positions that repeat the one before without a ground speed: they count as new ones.
    pub repeats_unjudged: u64,
    /// Number of reported positions to which the vehicle cannot have flown from the one before: one of the two is wrong. They are checked
    /// as they were reported.
    pub jumps: u64,
    /// Instant of the first of them, s of mission time.
    pub first_jump_s: Option<f64>,
    /// Number of these positions inside active restricted zones.
    pub inside_zones: u64,
    /// Number of these positions outside of the permitted area.
    pub outside_permitted: u64,
    /// Height over ground that the mission requires under way: that of its requirement `terrain`, without one a usual height.
    pub ground_margin_m: f64,
    /// Number of these positions below that height, without take-off, landing and climbs; a crash counts as one.
    pub near_ground: u64,
    /// Number of these positions beyond the required landing distance.
    pub beyond_landing_distance: u64,
    /// Parts of the flight in the air without a new position, s of mission time: nothing can be said about them.
    pub unverified_s: Vec<(f64, f64)>,
    /// Requirements that the flight announced as broken, in order.
    pub said_broken: Vec<ReportedViolation>,
    /// The first findings, in order.
    pub findings: Vec<Finding>,
}

impl CheckResult {
    /// Returns the number of violations: a position counts once for each requirement that is violated there.
    pub fn violations(&self) -> u64 {
        self.inside_zones + self.outside_permitted + self.near_ground + self.beyond_landing_distance
    }

    /// Returns true if there are positions in the air, every one keeps the requirements, and no part of the flight in the air is without
    /// positions.
    pub fn is_verified(&self) -> bool {
        self.violations() == 0 && self.unverified_s.is_empty() && self.nothing_checked().is_none()
    }

    /// Returns the reason if not a single position was checked.
    pub fn nothing_checked(&self) -> Option<&'static str> {
        match (self.steps, self.positions) {
            (0, _) => Some("the record holds no steps"),
            (_, 0) => Some("the record has no position of the vehicle in the air"),
            _ => None,
        }
    }

    /// Returns the sentences that state what the check could not judge.
    fn limits(&self) -> Vec<String> {
        let of = |count: u64, what: &str| (count > 0).then(|| format!("{count} of the positions {what}"));
        [
            of(self.height_unknown, "have no `height-above-ground`: they are not compared with the ground"),
            of(
                self.air_derived,
                "count as in the air by commands and positions: the vehicle reports neither `on-ground` nor `flight-phase`",
            ),
            of(
                self.repeats_unjudged,
                "repeat the one before, and no `ground-speed` is reported: whether the vehicle was there is not known",
            ),
            self.first_jump_s.map(|first_s| {
                let (jumps, first) = (self.jumps, Time::from_seconds(first_s));
                format!("{jumps} times, first at {first}, the reported position jumps farther than the vehicle can fly: one side of a jump is wrong")
            }),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Returns the kept findings about requirements that the flight had not announced as broken before.
    pub fn unsaid(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|finding| {
            !self.said_broken.iter().any(|said| said.t_s <= finding.t_s && said.is_about(&finding.violation))
        })
    }

    fn write_said_broken(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for ReportedViolation { t_s, names, why } in &self.said_broken {
            let (at, names) = (Time::from_seconds(*t_s), names.join("; "));
            write!(f, "\n{at}: the flight reported that it had to violate {names}: {why}")?;
        }
        Ok(())
    }
}

impl fmt::Display for CheckResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(reason) = self.nothing_checked() {
            write!(f, "not verified: nothing was checked, because {reason}")?;
            return self.write_said_broken(f);
        }
        writeln!(f, "{} positions in the air:", self.positions)?;
        writeln!(f, "  {:6} inside an active restricted zone", self.inside_zones)?;
        writeln!(f, "  {:6} outside of the permitted area", self.outside_permitted)?;
        match self.height_unknown {
            unknown if unknown >= self.positions && self.near_ground == 0 => {
                writeln!(
                    f,
                    "       ? under way below {:.0} m over ground: no position has a height over ground",
                    self.ground_margin_m
                )?;
            }
            _ => {
                let (count, required_m) = (self.near_ground, self.ground_margin_m);
                writeln!(f, "  {count:6} under way below {required_m:.0} m over ground, or crashed")?;
            }
        }
        write!(f, "  {:6} beyond the landing distance", self.beyond_landing_distance)?;
        for limit in self.limits() {
            write!(f, "\nnot judged: {limit}")?;
        }
        for (from_s, until_s) in &self.unverified_s {
            let [from, until] = [from_s, until_s].map(|at_s| Time::from_seconds(*at_s));
            let part = plain_duration(until - from);
            write!(
                f,
                "\nnot verified: from {from} to {until} ({part}) the vehicle was in the air and reported no new position"
            )?;
        }
        for finding in self.findings.iter().take(20) {
            let Position { latitude_deg, longitude_deg } = finding.position;
            let at = Time::from_seconds(finding.t_s);
            write!(
                f,
                "\n{at}: ({latitude_deg:.5} {longitude_deg:.5} {:.0} m) {:?}",
                finding.altitude_m, finding.violation
            )?;
        }
        self.write_said_broken(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of zones are free text: only whole names count.
    #[test]
    fn a_violation_is_said_if_a_report_has_the_name_of_its_zone() {
        let violation = |zone: &str| Finding {
            t_s: 60.0,
            position: Position { latitude_deg: 37.0, longitude_deg: -117.0 },
            altitude_m: 900.0,
            violation: Violation::Inside(zone.to_string()),
        };
        let unsaid = |said: &str, flown: &str| {
            let names = vec![said.to_string(), "permitted area".to_string()];
            let said_broken = vec![ReportedViolation { t_s: 50.0, names, why: "no way is open".to_string() }];
            CheckResult { said_broken, findings: vec![violation(flown)], ..CheckResult::default() }.unsaid().count()
        };
        assert_eq!(unsaid("range; north", "range; north"), 0);
        assert_eq!(unsaid("north: low part", "north"), 1);
    }
}
