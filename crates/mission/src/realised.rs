//! Realised and expected cost of ignorance of a simulated flight: a test of the metric with random fires.
//!
//! The cost of a fire is that of its structure's cost function for its age at the end of the visit that saw it; for its age at the
//! horizon if it was never seen. The expected cost is that of the same visits at the rates that the mission states. Both count visits in
//! which a picture was taken, and both end at the horizon of the mission or, if that is earlier, at the end of the flight. Over many seeds
//! the means are equal if every look detects (`detection` 1). Bound: O(fires x visits).

use crate::Mission;
use crate::problem::watched;
use crate::report::Report;
use apex_metrics::eci::{cost_at, expected_cost};
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind};
use apex_model::problem::SurveillanceVisit;
use apex_model::value::Value;
use apex_runtime::ports::Observer;

/// Fires and pictures of a flight, from the messages of the simulated world.
#[derive(Clone, Debug, Default)]
pub struct FireLog {
    /// Structure, and mission time at which its fire broke out.
    fires: Vec<(String, f64)>,
    /// Structure, instant at which its fire broke out, and instant at which it was seen.
    found: Vec<(String, f64, f64)>,
    /// Structure and instant of a picture.
    pictures: Vec<(String, f64)>,
}

/// Ignorance of one flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RealisedIgnorance {
    /// Fires that broke out until the horizon of the comparison.
    pub fires: usize,
    /// Number of fires seen up to the horizon.
    pub seen: usize,
    /// Cost of these fires.
    pub realised: f64,
    /// Expected cost of ignorance of the visits at the mission's rates.
    pub expected: f64,
}

impl FireLog {
    /// Compares with the report of the flight; `None` for missions without structures.
    pub fn compare(&self, mission: &Mission, report: &Report) -> Option<RealisedIgnorance> {
        let Ok(mut problem) = watched(mission) else {
            return None;
        };
        // No fire is known that breaks out after the flight.
        problem.horizon_s = problem.horizon_s.min(report.end.0.seconds());
        let visits: Vec<SurveillanceVisit> = report
            .visits
            .iter()
            .filter_map(|visit| {
                let (arrive_s, end_s) = (visit.begin.seconds(), visit.end?.seconds());
                let shown =
                    |(target, at_s): &(String, f64)| *target == visit.target && (arrive_s..=end_s).contains(at_s);
                self.pictures.iter().any(shown).then(|| SurveillanceVisit {
                    target: visit.target.clone(),
                    arrive_s,
                    end_s,
                })
            })
            .collect();
        let horizon_s = problem.horizon_s;
        let mut result =
            RealisedIgnorance { fires: 0, seen: 0, realised: 0.0, expected: expected_cost(&problem, &visits).total };
        for (site, broke_out_s) in self.fires.iter().filter(|(_, broke_out_s)| *broke_out_s <= horizon_s) {
            let Some(target) = problem.targets.iter().find(|target| target.name == *site) else { continue };
            let is_it = |(of, at_s, _): &&(String, f64, f64)| of == site && (at_s - broke_out_s).abs() < 1e-3;
            // Information counts at the end of a visit. A fire that was seen in passing counts at the end of the next visit: the
            // expected cost, which this one is compared with, knows visits only.
            let known_s = self.found.iter().find(is_it).map(|(_, _, seen_s)| {
                let ends = visits.iter().filter(|visit| visit.target == *site).map(|visit| visit.end_s);
                ends.filter(|end_s| end_s >= seen_s).fold(f64::INFINITY, f64::min)
            });
            let known_s = known_s.filter(|known_s| *known_s <= horizon_s);
            result.fires += 1;
            result.seen += usize::from(known_s.is_some());
            result.realised += cost_at(&target.cost, known_s.unwrap_or(horizon_s) - broke_out_s);
        }
        Some(result)
    }
}

impl Observer for FireLog {
    fn observe(&mut self, batch: &Batch, _: &[Effect]) -> Result<(), String> {
        for event in &batch.events {
            let EventKind::Occurrence(form) = &event.kind else { continue };
            let Some([Value::Symbol(head), first, rest @ ..]) = form.as_list() else { continue };
            let name = |value: &Value| value.as_symbol().map(|symbol| symbol.folded().to_string());
            let age_s = rest.first().and_then(Value::as_number).map(|(si, _)| si);
            let at_s = event.at.seconds();
            match (head.folded(), name(first), age_s) {
                ("truth-fire", Some(site), Some(age_s)) => self.fires.push((site, at_s - age_s)),
                ("truth-fire-seen", Some(site), Some(age_s)) => self.found.push((site, at_s - age_s, at_s)),
                ("image-taken", Some(_), _) => {
                    self.pictures.extend(rest.first().and_then(name).map(|site| (site, at_s)));
                }
                _ => {}
            }
        }
        Ok(())
    }
}
