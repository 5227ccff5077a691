//! Results: the factors of each wanted look, its points, and the causes of lost points.

use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// The four factors of a look. They are chained: each is a mean weighted by the preceding factors, so that their product is the mean
/// value of the wanted cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Factors {
    /// c: share of the wanted area that is seen.
    pub coverage: f64,
    /// s: mean clarity of the seen cells.
    pub clarity: f64,
    /// r: mean resolution factor, weighted by clarity.
    pub resolution: f64,
    /// o: mean timing factor, weighted by clarity and resolution.
    pub timing: f64,
}

impl Factors {
    /// Returns the product `c s r o`.
    pub fn product(&self) -> f64 {
        self.coverage * self.clarity * self.resolution * self.timing
    }
}

/// Cause of lost points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LossCause {
    /// Wanted ground that no look sees (outside every swath, occluded, beyond the horizon limit, gap in the record).
    NotSeen,
    /// The attitude is not recorded, so that clarity is unknown.
    AttitudeNotRecorded,
    /// The wings were not level.
    Roll,
    /// Angular rates shifted the lines.
    Rates,
    /// Gaps between lines: too fast or too low for the scan rate.
    LineGaps,
    /// Smear of a picture.
    Smear,
    /// Too dark for the exposure of a picture.
    TooDark,
    /// The sensor was not ready.
    SensorNotReady,
    /// Cloud between sensor and ground.
    Cloud,
    /// Glint of the sun on water.
    Glint,
    /// The pixels are too large.
    TooCoarse,
    /// The look angle is not the wanted one.
    LookAngle,
    /// Outside the windows of time.
    WrongTime,
    /// The value had fallen with time.
    ValueFallen,
    /// The wanted light was missing.
    NoLight,
    /// No pass of a required satellite is near in time.
    NoOverpass,
    /// The image was late on the ground or never arrived.
    LateOnGround,
    /// A target that must be seen before had not been seen.
    Order,
    /// Too soon or too late after the previous look.
    Interval,
}

impl LossCause {
    /// All causes, in the order in which the factors are chained.
    pub const ALL: [LossCause; 19] = [
        LossCause::NotSeen,
        LossCause::AttitudeNotRecorded,
        LossCause::Roll,
        LossCause::Rates,
        LossCause::LineGaps,
        LossCause::Smear,
        LossCause::TooDark,
        LossCause::SensorNotReady,
        LossCause::Cloud,
        LossCause::Glint,
        LossCause::TooCoarse,
        LossCause::LookAngle,
        LossCause::WrongTime,
        LossCause::ValueFallen,
        LossCause::NoLight,
        LossCause::NoOverpass,
        LossCause::LateOnGround,
        LossCause::Order,
        LossCause::Interval,
    ];

    /// Returns the cause as text for a report.
    pub fn words(self) -> &'static str {
        match self {
            LossCause::NotSeen => "not seen",
            LossCause::AttitudeNotRecorded => "attitude not recorded",
            LossCause::Roll => "roll",
            LossCause::Rates => "angular rates",
            LossCause::LineGaps => "gaps between lines",
            LossCause::Smear => "smear",
            LossCause::TooDark => "too dark for the camera",
            LossCause::SensorNotReady => "sensor not ready",
            LossCause::Cloud => "cloud",
            LossCause::Glint => "glint",
            LossCause::TooCoarse => "too coarse",
            LossCause::LookAngle => "look angle",
            LossCause::WrongTime => "wrong time",
            LossCause::ValueFallen => "value fallen with time",
            LossCause::NoLight => "wrong light",
            LossCause::NoOverpass => "no satellite pass near in time",
            LossCause::LateOnGround => "late on ground",
            LossCause::Order => "order",
            LossCause::Interval => "interval between looks",
        }
    }
}

/// Points lost to one cause.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Loss {
    /// Cause.
    pub cause: LossCause,
    /// Points.
    pub points: f64,
}

/// Unknown property of a look, so that its factors rest on an assumption.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Remark {
    /// The record has no attitude: clarity counts as 0.
    AttitudeNotRecorded,
    /// Cloud is unknown: it counts as clear.
    CloudNotKnown,
    /// The terrain at the target is unknown: the target's mean elevation is used.
    TerrainNotKnown,
    /// The scan rates of the sensor are not known: the V/H limit is not applied.
    ScanRateNotKnown,
    /// The time of arrival on the ground is unknown for some looks: they count as never arrived.
    ArrivalNotKnown,
}

/// Figures of what was seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeenFigures {
    /// Wanted area (or length in m for lines, 1 for points), times the wanted share.
    pub wanted: f64,
    /// Seen part of it.
    pub seen: f64,
    /// First instant of a look that counts.
    pub first_s: Option<f64>,
    /// Last instant of a look that counts.
    pub last_s: Option<f64>,
    /// First instant of a look that counts with a clarity above 0 (a valid look).
    pub first_valid_s: Option<f64>,
    /// Mean pixel size in the worst direction of the looks that count.
    pub pixel_m_mean: Option<f64>,
    /// Mean look angle of the looks that count.
    pub look_angle_deg_mean: Option<f64>,
    /// All passes of the target, counted or not.
    pub passes: usize,
}

/// Result of one wanted look.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LookResult {
    /// Name of the wanted look.
    pub name: String,
    /// v: points for a perfect look.
    pub value: f64,
    /// c, s, r, o.
    pub factors: Factors,
    /// `v c s r o`.
    pub points: f64,
    /// Cost of the look if it must not be missed and was missed.
    pub must_missed: Option<f64>,
    /// Points lost by cause, in the order of [`LossCause`]; the sum is `value - points`.
    pub losses: Vec<Loss>,
    /// Figures.
    pub seen: SeenFigures,
    /// Unknown properties.
    pub remarks: BTreeSet<Remark>,
}

/// Result of one target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetResult {
    /// Name of the target.
    pub name: String,
    /// Each wanted look, in the order of the mission.
    pub looks: Vec<LookResult>,
}

impl TargetResult {
    /// Returns the points of all looks.
    pub fn points(&self) -> f64 {
        self.looks.iter().map(|look| look.points).sum()
    }

    /// Returns the value of all looks.
    pub fn value(&self) -> f64 {
        self.looks.iter().map(|look| look.value).sum()
    }

    /// Returns the first instant of a valid look of the target, by which order constraints are judged.
    pub fn first_valid_s(&self) -> Option<f64> {
        self.looks.iter().filter_map(|look| look.seen.first_valid_s).reduce(f64::min)
    }
}
