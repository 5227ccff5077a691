//! The score as text for the terminal and as JSON for the record and for programs.

use super::value::{Cost, CostKind, FlightScore, ScoredLook};

use crate::observing::{CLARITY, COVERAGE, RESOLUTION, TIMING};
use crate::predicted::Predicted;
use crate::text::{name_width, wrapped, wrapped_line};
use apex_model::problem::QualityFactor;
use apex_observation::result::{LookResult, LossCause, Remark};
use serde_json::{Value, json};
use std::fmt::Write;

/// Losses below this many points are left out of the text.
const LOSS_REPORTED_MIN: f64 = 0.05;
/// Explanation of values in the rows of plans.
const VALUES_TOLD: &str = "  A value in the second row is the value that the plan expected: the value at the time of planning, less the \
     parts that had been seen and the parts that its other visits show.";

impl FlightScore {
    /// Returns the score for the record and for programs.
    pub(crate) fn json(&self) -> Value {
        let cost = |cost: &Cost| {
            let (kind, points) = (cost.kind.word(), cost.points());
            json!({"kind": kind, "name": cost.name, "quantity": cost.quantity, "price": cost.price, "points": points})
        };
        json!({
            "kind": "mission-score",
            "score": self.score,
            "benefits": self.benefits,
            "personnel_cost": self.cost_of(CostKind::Personnel),
            "failure_probability": self.failure_probability,
            "failure_cost": self.cost_of(CostKind::Failure),
            "missed_cost": self.cost_of(CostKind::Missed),
            "costs": self.costs.iter().map(cost).collect::<Vec<_>>(),
            "targets": self.looks.iter().map(look_json).collect::<Vec<_>>(),
            "not_known": self.trouble,
        })
    }

    /// Returns the score for operators.
    pub(crate) fn write(&self, out: &mut String) -> std::fmt::Result {
        if !self.trouble.is_empty() {
            return writeln!(out, "Mission score: not known, since {}", self.trouble);
        }
        let missed = self.cost_of(CostKind::Missed);
        write!(
            out,
            "Mission score {:.1} = benefits {:.1} - personnel {:.1} - failure {:.1} (P = {:.4})",
            self.score,
            self.benefits,
            self.cost_of(CostKind::Personnel),
            self.cost_of(CostKind::Failure),
            self.failure_probability
        )?;
        if missed > 0.0 {
            write!(out, " - missed {missed:.1}")?;
        }
        writeln!(out, "\n\nScore by factor: as flown, and below it as the plan predicted")?;
        let width = name_width("target", self.looks.iter().map(|look| look.name.as_str()));
        writeln!(
            out,
            "  {:<width$} {:>6} {:>9} {:>11} {:>9} {:>7} {:>7}",
            "target", "value", "coverage", "resolution", "clarity", "timing", "worth"
        )?;
        self.looks.iter().try_for_each(|look| write_look(out, look, width))?;
        match self.looks.iter().any(|look| planned_value(look).is_some()) {
            true => writeln!(out, "{}", wrapped_line(VALUES_TOLD)),
            false => Ok(()),
        }
    }
}

/// Returns the value that the plan counted, if it differs from the one as flown.
fn planned_value(look: &ScoredLook) -> Option<f64> {
    let counted = look.predicted.as_ref()?.value()?;
    ((counted - look.flown.value).abs() >= LOSS_REPORTED_MIN).then_some(counted)
}

fn write_look(out: &mut String, look: &ScoredLook, width: usize) -> std::fmt::Result {
    let LookResult { value, factors, points, remarks, .. } = &look.flown;
    let clarity = match remarks.contains(&Remark::AttitudeNotRecorded) {
        true => "not known".to_string(),
        false => format!("{:.2}", factors.clarity),
    };
    writeln!(
        out,
        "  {:<width$} {value:>6.1} {:>9.2} {:>11.2} {clarity:>9} {:>7.2} {points:>7.1}",
        look.name, factors.coverage, factors.resolution, factors.timing
    )?;
    let indent = " ".repeat(width + 3);
    if let Some(Predicted { quality, timing, worth, .. }) = &look.predicted {
        writeln!(
            out,
            "  {:<width$} {:>6} {:>9.2} {:>11.2} {:>9.2} {timing:>7.2} {worth:>7.1}",
            "",
            planned_value(look).map_or_else(String::new, |value| format!("{value:.1}")),
            quality.coverage.factor,
            quality.resolution.factor,
            quality.clarity.factor
        )?;
    }
    let mut told: Vec<String> = causes(&look.flown, &LossCause::ALL);
    told.extend(not_known(&look.flown));
    if told.is_empty() {
        return Ok(());
    }
    writeln!(out, "{indent}{}", wrapped(&told, "; ", indent.len(), &indent))
}

/// Returns `roll 3.1` for each of these causes that cost points.
fn causes(look: &LookResult, of: &[LossCause]) -> Vec<String> {
    let losses = look.losses.iter().filter(|loss| of.contains(&loss.cause) && loss.points >= LOSS_REPORTED_MIN);
    losses.map(|loss| format!("{} {:.1}", loss.cause.words(), loss.points)).collect()
}

/// Returns the unknown properties of the look as text.
fn not_known(look: &LookResult) -> Vec<String> {
    let words = |remark: &Remark| match remark {
        Remark::AttitudeNotRecorded => Some("not known: attitude, which the record does not hold"),
        Remark::ArrivalNotKnown => Some("not known: when images were on the ground"),
        Remark::ScanRateNotKnown => Some("not known: the scan rate, so gaps between lines are not counted"),
        // Most records lack these, so their absence is not reported.
        Remark::CloudNotKnown | Remark::TerrainNotKnown => None,
    };
    look.remarks.iter().filter_map(words).map(str::to_string).collect()
}

fn look_json(look: &ScoredLook) -> Value {
    let flown = &look.flown;
    let factor = |factor: f64, of: &[LossCause]| json!({"factor": factor, "cause": causes(flown, of).join("; ")});
    let clarity = match flown.remarks.contains(&Remark::AttitudeNotRecorded) {
        true => json!({"factor": Value::Null, "cause": "not known: the record holds no attitude"}),
        false => factor(flown.factors.clarity, &CLARITY),
    };
    json!({
        "id": look.id,
        "target": look.name,
        "value": flown.value,
        "coverage": factor(flown.factors.coverage, &COVERAGE),
        "resolution": factor(flown.factors.resolution, &RESOLUTION),
        "clarity": clarity,
        "timing": factor(flown.factors.timing, &TIMING),
        "worth": flown.points,
        "losses": flown.losses,
        "seen": flown.seen,
        "remarks": flown.remarks,
        "predicted": look.predicted.as_ref().map(predicted_json),
    })
}

fn predicted_json(predicted: &Predicted) -> Value {
    let factor = |factor: &QualityFactor| json!({"factor": factor.factor, "cause": factor.cause});
    json!({
        "coverage": factor(&predicted.quality.coverage),
        "resolution": factor(&predicted.quality.resolution),
        "clarity": factor(&predicted.quality.clarity),
        "timing": {"factor": predicted.timing, "cause": ""},
        "value": predicted.value(),
        "worth": predicted.worth,
        "begin_s": predicted.begin_s,
        "end_s": predicted.end_s,
    })
}
