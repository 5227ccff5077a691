//! The shipped missions and libraries, and their check with one text replaced.

use apex_pdl::{CheckOptions, Checked, HostSignature, Requirement, SourceText, Unresolved};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A text in which mistakes are made, and the program through which it is checked: a library is checked as part of the mission that uses
/// all libraries.
pub struct Place {
    /// The path from the root of the repository, as in the sources of the program.
    pub file: String,
    pub program: String,
}

pub struct Corpus {
    pub texts: BTreeMap<String, String>,
    pub places: Vec<Place>,
    host: Vec<HostSignature>,
}

const MISSIONS: [&str; 3] = [
    "missions/first-picture/mission.pdl",
    "missions/structure-watch/mission.pdl",
    "missions/western-states/mission.pdl",
];
/// Generated from vehicle files and missions, so authors make no mistakes in them.
const GENERATED: [&str; 2] = ["library/vehicle-figures.pdl", "library/lost-link-figures.pdl"];
/// Required by libraries and missions, and correct: mistakes are made in the other libraries.
const REQUIRED: [&str; 3] = ["library/interface.pdl", "library/requirements.pdl", "library/replanning.pdl"];
const LIBRARIES: [&str; 3] = ["library/aerial-observation.pdl", "library/contingencies.pdl", "library/vehicle.pdl"];

impl Corpus {
    pub fn new() -> Corpus {
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
        let read = |name: &str| (name.to_string(), std::fs::read_to_string(root.join(name)).unwrap());
        let texts =
            MISSIONS.iter().chain(&LIBRARIES).chain(&GENERATED).chain(&REQUIRED).map(|name| read(name)).collect();
        let of_mission = MISSIONS.iter().map(|name| Place { file: name.to_string(), program: name.to_string() });
        let of_library =
            LIBRARIES.iter().map(|name| Place { file: name.to_string(), program: MISSIONS[2].to_string() });
        let signature = |(name, least, most): (&str, usize, Option<usize>)| HostSignature {
            name: name.to_string(),
            parameters_min: least,
            parameters_max: most,
            pure: true,
        };
        let host = apex_geo::functions::host_signatures().into_iter().map(signature).collect();
        Corpus { texts, places: of_mission.chain(of_library).collect(), host }
    }

    /// Returns all texts of a program.
    pub fn program_texts(&self, place: &Place) -> Vec<&str> {
        let mission = &self.texts[&place.program];
        let uses = |library: &&&str| {
            let name = Path::new(library).file_stem().unwrap().to_str().unwrap();
            mission.contains(&format!("\"{name}\"")) || **library == "library/vehicle.pdl"
        };
        let libraries = LIBRARIES.iter().filter(uses).map(|name| &*self.texts[*name]);
        std::iter::once(&**mission).chain(libraries).collect()
    }

    /// Checks the program of `place` with `text` in its place.
    pub fn check(&self, place: &Place, text: &str) -> Checked {
        let text_of = |name: &str| -> Result<SourceText, String> {
            let known = self.texts.get(name).ok_or_else(|| format!("there is no {name}"))?;
            let text = if name == place.file { text } else { known };
            Ok(SourceText { name: name.to_string(), text: text.to_string() })
        };
        let mut resolve = |requirement| match requirement {
            Requirement::Library(name) => text_of(&format!("library/{name}.pdl")).map_err(|_| {
                let names = ["aerial-observation", "contingencies", "vehicle"].map(str::to_string).to_vec();
                Unresolved { reason: "no such library".to_string(), names }
            }),
            Requirement::File { name, .. } => Err(format!("there is no {name}").into()),
        };
        let program = text_of(&place.program).unwrap();
        apex_pdl::check(vec![program], CheckOptions { fragment: false, host: &self.host, resolve: &mut resolve })
    }
}
