//! Cases of manoeuvres: one mission for each, flown in the simulator and compared with the prediction.

use apex_mission::Mission;
use apex_mission::acquisition::{PerformedManoeuvre, forecast};
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::report::MissionValue;
use apex_model::value::Value;
use apex_observation::manoeuvres::{AttitudeMode, PayloadUse, SpeedProfile};
use std::path::Path;
use std::sync::Arc;

pub(crate) const STILL: &str = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,9000,0,0,0\n";
pub(crate) const WIND: &str = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,9000,250,4,0.02\n";

/// Permitted relative difference between predicted and flown energy, with wind and without.
const ENERGY_SHARE: f64 = 0.10;

/// Longitude and latitude, in the order of GeoJSON, of a place east and north of the pad.
pub(crate) fn place(east_m: f64, north_m: f64) -> String {
    let (latitude, longitude) = (40.0 + north_m / 111_034.0, -100.0 + east_m / 85_395.0);
    format!("[{longitude:.7}, {latitude:.7}]")
}

/// Returns a mission whose program performs one manoeuvre over a square field with its centre at this distance east of the pad.
pub(crate) fn mission(
    folder: &Path,
    model: &str,
    winds: &str,
    (away_m, half_m, up_m): (f64, f64, f64),
    goal: &str,
) -> Mission {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let corner = |x: f64, y: f64| place(away_m + x * half_m, y * half_m);
    let ring = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0)];
    write(
        "targets.geojson",
        &format!(
            r#"{{"type": "FeatureCollection", "features": [
{{"type": "Feature", "properties": {{"id": "pad", "kind": "base"}}, "geometry": {{"type": "Point", "coordinates": {}}}}},
{{"type": "Feature", "properties": {{"id": "field", "kind": "inspection", "value": 100, "resolution_m": 5}},
  "geometry": {{"type": "Polygon", "coordinates": [[{}]]}}}}]}}"#,
            place(0.0, 0.0),
            ring.join(", ")
        ),
    );
    write("winds.csv", winds);
    write(
        "mission.pdl",
        &format!(
            r#"(defapplication "Manoeuvre"
  :type native-sim
  :libraries ("vehicle" "aerial-observation" "manoeuvres")
  :vehicle (sim :model {model} :at pad)
  :start "2026-06-01T17:00:00Z"
  :duration 4h
  :targets "targets.geojson"
  :forecast "winds.csv"
  :agents ((agent uav-1 :initial-task (do it))))
(procedure :sequential
  (index (do it))
  (step up (take off to {up_m}m))
  (step fly {goal})
  (step home (return to pad at {up_m}m)))"#
        ),
    );
    Mission::load(folder).unwrap()
}

pub(crate) fn fly(mission: Arc<Mission>, path: &Path) -> FlightOutcome {
    fly_observed(mission, path, &mut EnergyFlow::default())
}

fn fly_observed(mission: Arc<Mission>, path: &Path, flow: &mut EnergyFlow) -> FlightOutcome {
    let mut recorder = apex_simulation::create_record(path, &mission, None).unwrap();
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let terms = MissionFlight::terms(&mission, None);
    apex_simulation::fly(mission, means, None, terms, &mut recorder, &mut [flow]).unwrap()
}

/// The rates at which a vehicle used energy, kg/s or W, with their instants.
#[derive(Default)]
struct EnergyFlow {
    samples: Vec<(f64, f64)>,
}

impl apex_runtime::ports::Observer for EnergyFlow {
    fn observe(&mut self, batch: &apex_model::event::Batch, _: &[apex_model::effect::Effect]) -> Result<(), String> {
        for event in &batch.events {
            let apex_model::event::EventKind::Measurement(variable, value) = &event.kind else { continue };
            if matches!(variable.attribute.folded(), "fuel-flow" | "battery-power") {
                let rate = value.as_number().map_or(0.0, |(rate, _)| rate);
                self.samples.push((batch.now.seconds(), rate));
            }
        }
        Ok(())
    }
}

impl EnergyFlow {
    /// Returns the energy used between two instants, kg or J: each sample holds until the next.
    fn used(&self, from_s: f64, until_s: f64) -> f64 {
        let ends = self.samples.iter().skip(1).map(|(at_s, _)| *at_s).chain([f64::INFINITY]);
        let spans = self.samples.iter().zip(ends);
        spans.map(|((at_s, rate), end_s)| rate * (end_s.min(until_s) - at_s.max(from_s)).max(0.0)).sum()
    }
}

/// Name and fields of a form.
pub(crate) type Form = (&'static str, &'static [(&'static str, f64)]);

/// One manoeuvre of one vehicle.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) model: &'static str,
    pub(crate) camera: &'static str,
    /// Name and fields; bare numbers are metres, metres per second, seconds, degrees.
    pub(crate) form: Form,
    /// Attitude that the form states.
    pub(crate) attitude: Option<AttitudeMode>,
    /// Pace that the form states.
    pub(crate) pace: Option<SpeedProfile>,
    /// Speed that the goal states.
    pub(crate) speed_mps: Option<f64>,
    pub(crate) payload: PayloadUse,
    /// Altitude of the take-off.
    pub(crate) up_m: f64,
    pub(crate) away_m: f64,
    pub(crate) half_m: f64,
    /// True if the clarity is compared like the coverage.
    pub(crate) compares_clarity: bool,
}

impl Default for Case {
    fn default() -> Case {
        Case {
            model: "rmax",
            camera: "camera-1",
            form: ("orbit", &[]),
            attitude: None,
            pace: None,
            speed_mps: Some(6.0),
            payload: PayloadUse::StillsEvery(10.0),
            up_m: 120.0,
            away_m: 400.0,
            half_m: 40.0,
            compares_clarity: false,
        }
    }
}

impl Case {
    pub(crate) fn value(&self) -> Value {
        let pair = |key: &str, value: Value| [Value::symbol(&format!(":{key}")), value];
        let fields = self.form.1.iter().flat_map(|(key, number)| pair(key, Value::Real(*number)));
        let mut items: Vec<Value> = std::iter::once(Value::symbol(self.form.0)).chain(fields).collect();
        match self.attitude {
            None => {}
            Some(AttitudeMode::Coordinated) => items.extend(pair("attitude", Value::symbol("coordinated"))),
            Some(AttitudeMode::Pointing) => items.extend(pair("attitude", Value::symbol("pointing"))),
            Some(AttitudeMode::Fixed { heading_deg }) => items.extend(pair("heading", Value::Real(heading_deg))),
        }
        let pace = self.pace.map(|pace| match pace {
            SpeedProfile::Airspeed(speed) => ("airspeed", speed),
            SpeedProfile::GroundSpeed(speed) => ("ground-speed", speed),
            SpeedProfile::Overlap(share) => ("overlap", share),
            SpeedProfile::SlowAtClosest(speed) => ("slow-at-closest", speed),
            SpeedProfile::Smear(pixels) => ("smear", pixels),
        });
        items.extend(
            pace.into_iter()
                .flat_map(|(head, figure)| pair("pace", Value::list([Value::symbol(head), Value::Real(figure)]))),
        );
        Value::list(items)
    }

    /// Returns the goal in PDL.
    fn goal(&self) -> String {
        let speed = self.speed_mps.map_or_else(String::new, |speed| format!("at {speed}m/s "));
        let steps = match self.payload {
            PayloadUse::StillsEvery(every_m) => format!("every {every_m}m"),
            PayloadUse::StillsInterval(interval_s) => format!("at interval {interval_s}s"),
            // A video is recorded as pictures.
            PayloadUse::Video | PayloadUse::LineScan => "at interval 1s".to_string(),
        };
        match self.form.0 {
            "pirouette" => format!("(look around field by {} with {})", self.value(), self.camera),
            _ if self.camera == "scanner" => format!("(scan field by {} {speed})", self.value()),
            _ => format!("(perform {} at field with {} {speed}{steps})", self.value(), self.camera),
        }
    }

    /// Flies the case in a wind and compares it with the prediction; `share` is the tolerance.
    fn check(&self, winds: &str, share: f64) -> Result<(), String> {
        let goal = self.goal();
        let name = format!("{} {goal}", self.model);
        let folder = tempfile::tempdir().unwrap();
        let mission = mission(folder.path(), self.model, winds, (self.away_m, self.half_m, self.up_m), &goal);
        let mission = Arc::new(mission);
        let form = self.value();
        let wanted = PerformedManoeuvre {
            form: &form,
            target: "field",
            sensor: Some(self.camera),
            speed_mps: self.speed_mps,
            payload: self.payload,
            from_s: 0.0,
        };
        let predicted = forecast(&mission, &wanted).unwrap_or_else(|why| panic!("{name}: {why}"));
        let mut flow = EnergyFlow::default();
        let flight = fly_observed(mission, &folder.path().join("flight.apex"), &mut flow);
        let text = flight.report.text();
        let MissionValue::Score(score) = &flight.report.value else { panic!("{name}: of another kind") };
        let visit = flight.report.visits.first().unwrap_or_else(|| panic!("{name}: {text}"));
        let end = visit.end.unwrap_or_else(|| panic!("{name} does not end: {text}"));
        let flown_s = (end - visit.begin).seconds();
        let flown = &score.looks[0].flown.factors;
        let used = flow.used(visit.begin.seconds(), end.seconds());
        println!(
            "{name}: {flown_s:.1} s flown, {:.1} s predicted; energy {used:.3} flown, {:.3} predicted; coverage {:.3} flown, {:.3} predicted; clarity {:.3}, {:.3}; resolution {:.3}, {:.3}",
            predicted.time_s,
            predicted.energy,
            flown.coverage,
            predicted.factors.coverage,
            flown.clarity,
            predicted.factors.clarity,
            flown.resolution,
            predicted.factors.resolution
        );
        let off_s = (flown_s - predicted.time_s).abs();
        let unclear = if self.compares_clarity { (flown.clarity - predicted.factors.clarity).abs() } else { 0.0 };
        let off = (flown.coverage - predicted.factors.coverage).abs().max(unclear);
        // The simulator answers at steps of half a second.
        let agrees = off_s <= share * predicted.time_s + 1.0
            && off <= share
            && predicted.factors.coverage > 0.1
            && (used - predicted.energy).abs() <= ENERGY_SHARE * predicted.energy;
        if agrees { Ok(()) } else { Err(format!("{name} in {winds}")) }
    }
}

/// Checks all cases, and reports all that differ in one message.
pub(crate) fn all(cases: impl Iterator<Item = Case>, winds: &str, share: f64) {
    let wrong: Vec<String> = cases.filter_map(|case| case.check(winds, share).err()).collect();
    assert_eq!(wrong, Vec::<String>::new());
}
