//! Modes of manoeuvres: attitude, pace, recording and sensor, flown as predicted by rotorcraft and fixed wings.
//!
//! Each path is flown in each pace; attitudes and recordings alternate, so that each occurs with each path, and wind blows in every second
//! flight. `APEX_MODES=all` flies every combination.

use super::cases::{Case, Form, STILL, WIND, all, mission};
use super::{ASIDE, FIXED_WING, Flown, ORBIT, OVER, SECTOR, SPIRAL, SQUARE, STRAFE, SWEEP};
use apex_mission::acquisition::{PerformedManoeuvre, forecast, synthesised};
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::MissionFlight;
use apex_observation::manoeuvres::{AttitudeMode, PayloadUse, SpeedProfile};
use std::sync::Arc;

const ATTITUDES: [AttitudeMode; 3] =
    [AttitudeMode::Coordinated, AttitudeMode::Fixed { heading_deg: 40.0 }, AttitudeMode::Pointing];
/// A video is recorded as pictures.
const PAYLOADS: [PayloadUse; 3] = [PayloadUse::StillsEvery(10.0), PayloadUse::StillsInterval(2.0), PayloadUse::Video];

fn paces(speed_mps: f64) -> [SpeedProfile; 5] {
    [
        SpeedProfile::Airspeed(speed_mps),
        SpeedProfile::GroundSpeed(speed_mps),
        SpeedProfile::Overlap(0.6),
        SpeedProfile::SlowAtClosest(speed_mps),
        SpeedProfile::Smear(0.4),
    ]
}

/// Returns the cases of the paths in all paces, with some of the attitudes and recordings, or all of them.
fn combined(paths: &[(Form, f64)], attitudes: &[AttitudeMode], usual: &Case) -> Vec<Case> {
    let flies_all = std::env::var("APEX_MODES").is_ok_and(|text| text == "all");
    let mut cases = Vec::new();
    for (path, (form, half_m)) in paths.iter().enumerate() {
        for (index, pace) in paces(usual.speed_mps.unwrap_or(6.0)).into_iter().enumerate() {
            for (number, attitude) in attitudes.iter().enumerate() {
                for (step, payload) in PAYLOADS.into_iter().enumerate() {
                    let turn = (path + index) % attitudes.len() == number && (path + 2 * index) % 3 == step;
                    if flies_all || turn {
                        let (attitude, pace) = (Some(*attitude), Some(pace));
                        let modes = Case { attitude, pace, payload, speed_mps: None, ..usual.clone() };
                        cases.push(Case { form: *form, half_m: *half_m, ..modes });
                    }
                }
            }
        }
    }
    cases
}

/// Returns every second case, unless all are flown.
fn in_wind(cases: Vec<Case>) -> impl Iterator<Item = Case> {
    let step = if std::env::var("APEX_MODES").is_ok_and(|text| text == "all") { 1 } else { 2 };
    cases.into_iter().step_by(step)
}

fn rotorcraft() -> Vec<Case> {
    let paths = [
        (OVER, 100.0),
        (ASIDE, 40.0),
        (SPIRAL, 160.0),
        (ORBIT, 40.0),
        (STRAFE, 40.0),
        (SQUARE, 140.0),
        (SECTOR, 200.0),
        (SWEEP, 100.0),
    ];
    // The camera of the quadrotor pans, so that it sees the target with the nose in any direction.
    combined(&paths, &ATTITUDES, &Case { model: "quadrotor", ..Case::default() })
}

fn fixed_wing() -> Vec<Case> {
    let usual = Case { model: "fixed-wing-mapper", speed_mps: Some(14.0), away_m: 800.0, ..Case::default() };
    combined(&FIXED_WING, &ATTITUDES[..1], &usual)
}

/// Fixed wings with a turret that pans, and with the scanner.
fn large() -> Vec<Case> {
    let usual = Case { model: "predator-b", up_m: 2_000.0, away_m: 15_000.0, half_m: 1_000.0, ..Case::default() };
    let turret = Case { payload: PayloadUse::StillsInterval(3.0), speed_mps: Some(95.0), ..usual.clone() };
    let orbit: Form = ("orbit", &[("radius", 4_000.0), ("height", 2_000.0), ("turns", 1.0), ("azimuth", 180.0)]);
    let aside: Form = ("stand-off", &[("track", 90.0), ("height", 2_000.0), ("look-angle", 50.0), ("length", 3_000.0)]);
    let over: Form = ("straight-over", &[("track", 90.0), ("height", 2_000.0), ("length", 3_000.0)]);
    let near: Form = ("stand-off", &[("track", 0.0), ("height", 2_000.0), ("look-angle", 25.0), ("length", 3_000.0)]);
    let mut cases: Vec<Case> = [orbit, aside, over].map(|form| Case { form, ..turret.clone() }).into();
    for pace in paces(90.0) {
        cases.push(Case { form: orbit, pace: Some(pace), speed_mps: None, ..turret.clone() });
    }
    let scanner = Case { camera: "scanner", payload: PayloadUse::LineScan, speed_mps: Some(95.0), ..usual };
    cases.extend([over, near].map(|form| Case { form, ..scanner.clone() }));
    let sweep: Form = ("sweep", &[("height", 2_000.0)]);
    cases.push(Case { form: sweep, half_m: 4_000.0, ..scanner });
    cases
}

#[test]
fn a_rotorcraft_flies_every_mode_as_predicted() {
    all(rotorcraft().into_iter(), STILL, 0.05);
    all(in_wind(rotorcraft()), WIND, 0.10);
}

#[test]
fn a_fixed_wing_flies_every_mode_as_predicted() {
    all(fixed_wing().into_iter(), STILL, 0.05);
    all(in_wind(fixed_wing()), WIND, 0.10);
}

#[test]
fn a_large_fixed_wing_flies_with_turret_and_scanner_as_predicted() {
    all(large().into_iter(), STILL, 0.05);
    all(in_wind(large()), WIND, 0.10);
}

/// The aircraft passes the first point of a path before it gets the command to follow it. It turned back to that point, and passed within
/// 260 m of the middle of a circle with a radius of 6 km.
#[test]
fn a_fixed_wing_does_not_turn_back_to_the_first_point_of_a_path() {
    for radius_m in [3_500.0, 4_000.0, 6_000.0] {
        let folder = tempfile::tempdir().unwrap();
        let goal = format!(
            "(perform (orbit :radius {radius_m}m :height 2000m :turns 1) at field with camera-1 at 95m/s every 500m)"
        );
        let mission = Arc::new(mission(folder.path(), "predator-b", STILL, (15_000.0, 300.0, 2_000.0), &goal));
        let middle = mission.targets.iter().find(|target| target.id == "field").unwrap().position;
        let mut recorder = apex_simulation::create_record(&folder.path().join("f.apex"), &mission, None).unwrap();
        let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
        let terms = MissionFlight::terms(&mission, None);
        let mut flown = Flown::default();
        apex_simulation::fly(mission, means, None, terms, &mut recorder, &mut [&mut flown]).unwrap();
        let circle = flown.samples.iter().filter(|sample| sample.is_manoeuvring);
        let distances: Vec<f64> = circle.map(|sample| apex_geo::geodesy::distance_m(middle, sample.place)).collect();
        let off_m = distances.iter().map(|distance_m| (distance_m - radius_m).abs()).fold(0.0, f64::max);
        assert!(distances.len() > 50 && off_m < 0.05 * radius_m, "{off_m} m off a circle of {radius_m} m");
    }
}

/// A camera that does not pan sees its target only where the nose points at it.
#[test]
fn an_attitude_in_which_the_camera_does_not_see_is_refused_with_the_one_that_works() {
    let folder = tempfile::tempdir().unwrap();
    let why = |model: &str, case: &Case| {
        let mission = mission(folder.path(), model, STILL, (400.0, 40.0, 120.0), "(wait 1s)");
        let form = case.value();
        let wanted = PerformedManoeuvre {
            form: &form,
            target: "field",
            sensor: None,
            speed_mps: Some(6.0),
            payload: PayloadUse::Video,
            from_s: 0.0,
        };
        forecast(&mission, &wanted).unwrap_err()
    };
    let stated = |form: Form, attitude: AttitudeMode| Case { form, attitude: Some(attitude), ..Case::default() };
    for form in [ORBIT, ASIDE] {
        for attitude in ATTITUDES.into_iter().filter(|attitude| *attitude != AttitudeMode::Pointing) {
            let why = why("rmax", &stated(form, attitude));
            assert!(why.contains("`camera-1` does not pan") && why.ends_with("`:attitude pointing` works"), "{why}");
        }
    }
    assert!(why("rmax", &stated(STRAFE, AttitudeMode::Coordinated)).ends_with("leave `:attitude` out"));
    let fixed = why("fixed-wing-mapper", &stated(OVER, AttitudeMode::Fixed { heading_deg: 10.0 }));
    assert!(fixed.contains("fly it coordinated"), "{fixed}");
}

/// Data that a mission sends while it flies are on the ground earlier than those that are read after the landing.
#[test]
fn a_latency_is_met_by_the_link_of_the_mission() {
    let folder = tempfile::tempdir().unwrap();
    let far = |latency: &str| {
        drop(mission(folder.path(), "rmax", STILL, (3_000.0, 40.0, 120.0), "(wait 1s)"));
        let file = folder.path().join("mission.pdl");
        let program = std::fs::read_to_string(&file).unwrap().replace(":duration 4h", latency);
        std::fs::write(&file, program).unwrap();
        apex_mission::Mission::load(folder.path()).unwrap()
    };
    let goal = super::acquire(
        "field",
        &[
            ("resolution", super::length(0.2)),
            ("latency", apex_model::value::Value::Duration(apex_model::time::Duration::from_seconds(60.0))),
        ],
    );
    let why = synthesised(&far(":duration 4h"), &goal, 0.0).unwrap_err();
    assert!(why.contains("data are read after landing"), "{why}");
    assert!(synthesised(&far(":duration 4h :images-on-ground 40s"), &goal, 0.0).is_ok());
    let why = synthesised(&far(":duration 4h :images-on-ground 90s"), &goal, 0.0).unwrap_err();
    assert!(why.contains("on the ground 90 s after the observation, `:latency` is 60 s"), "{why}");
}
