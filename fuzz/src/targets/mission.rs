//! Data files of a mission: targets as GeoJSON, KML or CSV, airfields, airspace, wind and a vehicle.
//!
//! The first byte of the input selects the file that is replaced by the rest; all other files are those of `structure-watch`. Properties:
//! a mission that loads has targets at finite positions, and a rejection states the problem.

use crate::planted;
use apex_mission::Mission;
use apex_model::source::SourceFile;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// A mission as stored in a flight record.
struct Stored {
    program: Vec<SourceFile>,
    data: Vec<(String, Vec<u8>)>,
}

static STORED: LazyLock<Stored> = LazyLock::new(|| {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../missions/structure-watch");
    let checked = apex_mission::program::load_program(&folder)
        .unwrap_or_else(|error| panic!("structure-watch does not check: {error}"));
    Stored { program: checked.library.sources.clone(), data: data_files(&folder) }
});

fn data_files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let listed = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<(String, Vec<u8>)> = listed
        .filter_map(|entry| {
            let path = entry.ok()?.path();
            let name = path.file_name()?.to_str()?.to_string();
            let is_data = !name.ends_with(".pdl") && !name.ends_with(".md") && path.is_file();
            is_data.then(|| std::fs::read(&path).ok()).flatten().map(|bytes| (name, bytes))
        })
        .collect();
    files.sort();
    files
}

/// Runs the target.
pub(crate) fn run(bytes: &[u8]) {
    let Some((choice, body)) = bytes.split_first() else { return };
    if body.len() > super::TEXT_BYTES_MAX {
        return;
    }
    let mut data = STORED.data.clone();
    let count = data.len().max(1);
    if let Some((_, file)) = data.get_mut(usize::from(*choice) % count) {
        *file = body.to_vec();
    }
    match Mission::from_sources(&STORED.program, data) {
        Ok(mission) => {
            if planted::ARE_IN {
                // The bug: every mission is taken to have a target.
                let first = mission.targets.first();
                assert!(first.is_some(), "the first target of a mission without targets");
            }
            for target in &mission.targets {
                let (latitude, longitude) = (target.position.latitude_deg, target.position.longitude_deg);
                assert!(latitude.abs() <= 90.0 && longitude.abs() <= 360.0, "target `{}` is off the globe", target.id);
            }
        }
        Err(error) => assert!(!error.headline().is_empty(), "a refusal without a message"),
    }
}
