//! A mission is the same from its folder and from the sources that a flight record stores.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test stops at an unexpected result")]

use apex_mission::Mission;
use apex_mission::error::ErrorKind;
use std::path::{Path, PathBuf};

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions").join(name)
}

fn data(mission: &Mission) -> Vec<(String, Vec<u8>)> {
    mission.data.iter().cloned().collect()
}

#[test]
fn recorded_sources_load_as_the_folder_does() {
    for name in ["day-and-night", "first-picture", "pipeline-inspection", "structure-watch", "western-states"] {
        let of_folder = Mission::load(&folder(name)).unwrap();
        let of_record = Mission::from_sources(&of_folder.library.sources, data(&of_folder)).unwrap();
        assert!(!of_folder.data.is_empty(), "{name}");
        assert_eq!(of_record.data, of_folder.data, "{name}");
        let told =
            |mission: &Mission| format!("{:?}", (&mission.targets, &mission.zones, &mission.forecasts, mission.start));
        assert_eq!(told(&of_record), told(&of_folder), "{name}");
        assert_eq!(of_record.scenario, of_folder.scenario, "{name}");
    }
}

#[test]
fn an_error_names_kind_and_place() {
    let mission = Mission::load(&folder("structure-watch")).unwrap();
    let mut broken = data(&mission);
    let winds = broken.iter_mut().find(|(name, _)| name == "winds.csv").unwrap();
    winds.1 = b"altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps\n0,100,west,3\n".to_vec();
    let error = Mission::from_sources(&mission.library.sources, broken).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Data);
    assert_eq!(error.place.as_deref(), Some("winds.csv:2"));
    assert_eq!(error.message, "`wind_from_deg` is `west`, not a number");

    let without: Vec<_> = data(&mission).into_iter().filter(|(name, _)| name != "winds.csv").collect();
    let error = Mission::from_sources(&mission.library.sources, without).unwrap_err();
    assert_eq!(error.message, "cannot read winds.csv");
    assert!(error.help.unwrap().contains("sites.geojson"));
}

#[test]
fn turbulence_is_read_as_edr_and_the_former_column_as_half_its_number() {
    let mission = Mission::load(&folder("structure-watch")).unwrap();
    let with = |table: &str| {
        let mut changed = data(&mission);
        changed.iter_mut().find(|(name, _)| name == "winds.csv").unwrap().1 = table.as_bytes().to_vec();
        Mission::from_sources(&mission.library.sources, changed)
    };
    let columns = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps";
    let edr = |table: &str| with(table).unwrap().forecasts[0].1.layers[0].edr;
    assert_eq!(edr(&format!("{columns},edr\n0,100,270,3,0.2\n")), 0.2);
    assert_eq!(edr(&format!("{columns},turbulence\n0,100,270,3,0.2\n")), 0.1);
    assert_eq!(edr(&format!("{columns}\n0,100,270,3\n")), 0.0);
    let both = with(&format!("{columns},edr,turbulence\n0,100,270,3,0.2,0.4\n")).unwrap_err();
    assert_eq!(both.message, "both `edr` and `turbulence` are given");
    assert_eq!(both.place.as_deref(), Some("winds.csv:2"));
    let beyond = with(&format!("{columns},edr\n0,100,270,3,1.2\n")).unwrap_err();
    assert_eq!(beyond.message, "`edr` is 1.2, which is not between 0 and 1");
}

#[test]
fn errors_of_the_program_are_values() {
    let folder = tempfile::TempDir::new().unwrap();
    let program = folder.path().join("mission.pdl");
    std::fs::write(&program, "(procedure (index (a)) (step b (c) (waitfor (end ?d))))").unwrap();
    let error = Mission::load(&program).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Program);
    assert!(error.diagnostics.unwrap().has_errors());
}

#[test]
fn a_circle_of_targets_that_come_after_each_other_is_named() {
    let mission = Mission::load(&folder("pipeline-inspection")).unwrap();
    let with = |id: &str, after: &str| {
        let mut changed = data(&mission);
        for (_, bytes) in changed.iter_mut().filter(|(name, _)| name.ends_with("geojson")) {
            let text = String::from_utf8(bytes.clone()).unwrap();
            let from = format!("\"id\": \"{id}\"");
            *bytes = text.replace(&from, &format!("{from}, \"after\": [\"{after}\"]")).into_bytes();
        }
        Mission::from_sources(&mission.library.sources, changed)
    };
    assert!(with("valve-1", "marker-2").is_ok());
    let own = with("valve-1", "valve-1").unwrap_err();
    assert_eq!(own.message, "`after` is a circle: valve-1 after valve-1");
}
