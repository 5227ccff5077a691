//! Altitudes of manoeuvres: requirements that the flight keeps are kept by the plan.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

use apex_mission::Mission;
use apex_mission::problem::pose;
use apex_mission::situation::Situation;
use apex_model::problem::{Manoeuvre, Problem};
use apex_model::time::Time;

/// Rougher and windier at 4,000 m than near the ground and at 10,000 m, linear between.
const AIR: &str = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,1000,270,5,0.02\n3000,5000,270,25,0.12\n\
                   9000,11000,270,5,0.02\n";
/// Rougher only from the second hour on.
const LATER: &str = "altitude_m_min,altitude_m_max,from_h,until_h,wind_from_deg,wind_speed_mps,edr\n0,1000,,,270,5,0.02\n\
                     3000,5000,,1,270,5,0.02\n3000,5000,1,,270,25,0.12\n9000,11000,,,270,5,0.02\n";
/// Rough everywhere.
const ROUGH: &str =
    "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,2000,270,5,0.05\n2000,20000,270,5,0.3\n";

/// Returns a Predator B and one fire at 600 m, 50 km north of the field.
fn mission(air: &str, requirements: &str) -> Mission {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    put(
        "places.geojson",
        r#"{"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"id": "home", "kind": "base"}, "geometry": {"type": "Point", "coordinates": [-115, 40]}},
            {"type": "Feature", "properties": {"id": "fire", "kind": "fire", "value": 100, "acres": 2000, "resolution_m": 6, "elevation_m": 600},
             "geometry": {"type": "Point", "coordinates": [-115, 40.45]}}]}"#,
    );
    put("air.csv", air);
    put(
        "mission.pdl",
        &format!(
            r#"(defapplication "Altitudes"
  :type native-sim
  :libraries ("vehicle" "aerial-observation")
  :vehicle (sim :model predator-b :at home)
  :duration 6h
  :targets "places.geojson"
  :forecast "air.csv"
  :requirements ({requirements})
  :agents ((agent uav-1 :initial-task (map them))))
(procedure (index (map them)) (step done (terminate)))"#
        ),
    );
    Mission::load(folder.path()).unwrap_or_else(|error| panic!("{error:?}"))
}

fn manoeuvres(air: &str, requirements: &str) -> Result<Vec<Manoeuvre>, String> {
    match pose(&mission(air, requirements), &Situation::default(), None, Time::ZERO) {
        Ok(Problem::SingleVisit(problem)) => Ok(problem.targets[0].manoeuvres.clone()),
        Ok(Problem::Surveillance(_)) => panic!("of another kind"),
        Err(why) => Err(why.to_string()),
    }
}

/// Returns the lowest and the highest altitude of the manoeuvres.
fn altitudes_m(air: &str, requirements: &str) -> (f64, f64) {
    let all = manoeuvres(air, requirements).unwrap();
    let altitudes = all.iter().map(|one| one.altitude_m);
    (altitudes.clone().fold(f64::INFINITY, f64::min), altitudes.fold(0.0, f64::max))
}

#[test]
fn lines_keep_the_clearance_of_requirement_terrain() {
    let (usual_m, _) = altitudes_m(AIR, "");
    assert!(usual_m < 4_600.0, "{usual_m}");
    let (lowest_m, _) = altitudes_m(AIR, "(terrain :clearance 4000m)");
    assert!(lowest_m >= 4_610.0, "{lowest_m}");
    let refused = manoeuvres(AIR, "(terrain :clearance 14km)").unwrap_err();
    assert!(refused.contains("requirement terrain") && refused.contains("14610 m"), "{refused}");
}

#[test]
fn lines_keep_out_of_air_rougher_than_requirement_turbulence_permits() {
    assert!(altitudes_m(AIR, "").0 < 5_000.0);
    // The turbulence falls from 0.12 at 4,000 m to 0.02 at 10,000 m: 0.1 is at 5,200 m.
    let (lowest_m, _) = altitudes_m(AIR, "(turbulence :at-most 0.1)");
    assert!((5_200.0..=5_260.0).contains(&lowest_m), "{lowest_m}");
    let (always_m, _) = altitudes_m(LATER, "(turbulence :at-most 0.1)");
    assert!(always_m >= 5_200.0, "{always_m}");
    let refused = manoeuvres(ROUGH, "(turbulence :at-most 0.06)").unwrap_err();
    let told = "requirement turbulence permits at most 0.06 m^(2/3)/s, and the forecast has at least 0.";
    assert!(refused.contains(told), "{refused}");
}

#[test]
fn lines_keep_out_of_wind_stronger_than_requirement_wind_permits() {
    let (lowest_m, _) = altitudes_m(AIR, "(wind :at-most 15m/s)");
    assert!((7_000.0..=7_060.0).contains(&lowest_m), "{lowest_m}");
}
