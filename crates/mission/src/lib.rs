//! A mission: the contents of a `(defapplication ..)`, read from files and ready to plan and fly.

pub mod acquisition;
pub mod check_report;
mod closing;
pub mod clouds;
pub mod comparison;
mod costs;
pub mod crew;
mod data_doubts;
pub mod deliberation;
mod descent;
pub mod diagnosis;
mod doubts;
pub mod downlink;
mod energy;
pub mod error;
pub mod export;
mod features;
pub mod files;
pub mod fixing;
pub mod flight;
pub mod fork;
mod ground;
mod in_air;
pub mod link;
mod link_form;
mod link_level;
pub mod link_map;
pub mod lost_link;
mod manoeuvres;
mod modems;
pub mod monitor_report;
pub mod names;
mod observing;
pub mod plan;
mod position;
mod predicted;
pub mod problem;
pub mod program;
pub mod realised;
pub mod recorded;
pub mod recording;
pub mod replacing;
pub mod report;
mod report_text;
pub mod requirements;
pub mod scenario;
pub mod score;
mod settings;
mod site_pictures;
pub mod situation;
mod sources;
pub mod storm;
mod surroundings;
mod tables;
mod targets;
mod terrain;
pub mod text;
pub mod vehicle;
pub mod verification;
mod visit_altitude;
pub mod ways;
mod wind_error;

pub use modems::Modem;
pub use settings::Settings;
pub use sources::WorldText;
pub use surroundings::Airfield;
pub use targets::{Fire, PictureTerms, Site, Target, TargetKind};

use crate::error::{MissionError, MissionResult};
use apex_geo::{geodesy, terrain::Terrain};
use apex_model::library::{AgentDeclaration, Library};
use apex_model::planned::Location;
use apex_model::problem::{AirspaceZone, CrewMember, FailureTerm, LandingPlace, Position, WindField};
use apex_model::source::SourceFile;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use requirements::Requirements;
use sources::{DataFile, Sources};
use std::path::Path;
use std::sync::Arc;
use targets::Terms;
use vehicle::VehicleModel;

/// A mission with all of its data.
#[derive(Debug, Clone)]
pub struct Mission {
    /// Settings of the application.
    pub settings: Settings,
    /// The checked program.
    pub library: Arc<Library>,
    /// The agent that flies, the first that is declared: the vehicle has its name.
    pub agent: AgentDeclaration,
    /// The vehicle.
    pub model: VehicleModel,
    /// Place of start and landing.
    pub start: Position,
    /// Altitude of the start above mean sea level.
    pub start_altitude_m: f64,
    /// Targets and named places.
    pub targets: Vec<Target>,
    /// Airspace.
    pub zones: Vec<AirspaceZone>,
    /// Airfields.
    pub airfields: Vec<Airfield>,
    /// The terrain, if the mission has files of it; without them ground is known only at targets and airfields.
    pub terrain: Option<Arc<Terrain>>,
    /// Highest ground of `terrain` between and around targets and airfields; negative infinity without terrain.
    pub highest_ground_m: f64,
    /// Wind that the planner assumes.
    pub forecast: WindField,
    /// All forecasts by the names of their files: the first is assumed at the start, others when a message announces them.
    pub forecasts: Vec<(String, WindField)>,
    /// Clouds that the planner assumes.
    pub clouds: Vec<clouds::CloudDeck>,
    /// Wind of the simulated world.
    pub weather: WindField,
    /// Working times of the crew.
    pub crew: Vec<CrewMember>,
    /// Cost of failure.
    pub failure: FailureTerm,
    /// Scripted inputs.
    pub scenario: Vec<Input>,
    /// Requirements of the flight.
    pub requirements: Requirements,
    /// Radios of the simulated world.
    pub modems: Vec<Modem>,
    /// Radios as the planner assumes them.
    pub link_map: Vec<link_map::StatedLink>,
    /// Targets that plans leave out because their link is weak, each with the reason; empty before links are evaluated.
    pub weak_targets: Vec<(String, String)>,
    /// Loss of a link: criterion and response.
    pub lost_link: lost_link::LostLink,
    /// The dependency model by which test outcomes are diagnosed in flight.
    pub diagnosis: Option<Arc<apex_diagnosis::Model>>,
    /// The dynamic world of the simulation, for the simulator.
    pub world: Option<WorldText>,
    /// Data files by name with their bytes, for the record; shared, since each plan is made for a copy of the mission.
    pub data: Arc<Vec<(String, Vec<u8>)>>,
}

impl Mission {
    /// Loads the mission of a folder or of a program file, for example `mission.pdl`. Warnings of the program are dropped.
    ///
    /// # Errors
    /// An error in the program, the settings or the data.
    pub fn load(path: &Path) -> MissionResult<Mission> {
        let checked = program::load_program(path)?;
        Mission::of_program(path, Arc::new(checked.library))
    }

    /// Reads the data of a checked program that was loaded from `path`, a folder or a program file.
    ///
    /// # Errors
    /// An error in the settings or the data.
    pub fn of_program(path: &Path, library: Arc<Library>) -> MissionResult<Mission> {
        let folder = program::program_path(path).parent().map(Path::to_path_buf).unwrap_or_default();
        Mission::read(library, &Sources::Folder(folder))
    }

    /// Loads a mission from the texts of its program in load order and its data files by name, as stored in a flight record.
    ///
    /// # Errors
    /// Errors of the program under this version, and all errors of the settings and the data.
    pub fn from_sources(program: &[SourceFile], data: Vec<(String, Vec<u8>)>) -> MissionResult<Mission> {
        let (library, _, _) = program::load_recorded(program)
            .map_err(|reason| MissionError::program("the recorded mission cannot be loaded").because(reason))?;
        Mission::read(library, &Sources::Held(data))
    }

    fn read(library: Arc<Library>, sources: &Sources) -> MissionResult<Mission> {
        let settings = settings::read(&library)?;
        let named = settings.clone();
        let mut files =
            Files { sources, place_of: &|option: &str| named.place_of(option).to_string(), data: Vec::new() };
        let model = vehicle::load(&settings.model, &mut files)?;
        let terrain = files.terrain(&settings.terrain)?;
        let terms = Terms {
            duration_s: settings.duration.seconds(),
            epoch_unix_s: settings.epoch_unix_s,
            money_per_point: settings.value_unit,
            terrain: terrain.as_ref(),
        };
        let mut targets =
            files.read("targets", &settings.targets, |file| targets::read(file, terms))?.unwrap_or_default();
        costs::apply(&settings, &library, &mut targets)?;
        let airfields = files
            .read("airfields", &settings.airfields, |file| surroundings::airfields(file, terrain.as_deref()))?
            .unwrap_or_default();
        let forecasts = files.forecasts(&settings.forecasts)?;
        let forecast = forecasts.first().map(|(_, wind)| wind.clone());
        let weather = files.read("weather", &settings.weather, surroundings::wind)?;
        let has_fires = targets.iter().any(|target| matches!(target.kind, TargetKind::Fire(_)));
        let mut mission = Mission {
            requirements: requirements::state(&settings.stated_requirements(has_fires), &model)?,
            agent: program::agent_of(&library),
            zones: files.read("airspace", &settings.airspace, surroundings::airspace)?.unwrap_or_default(),
            crew: files
                .read("people", &settings.people, |file| surroundings::people(file, settings.value_unit))?
                .unwrap_or_default(),
            diagnosis: files
                .read("diagnosis", &settings.diagnosis, |file| diagnosis::parse(&file.place, &file.text()?))?,
            world: files.read("world", &settings.world, |file| {
                Ok(WorldText { place: file.place.clone(), text: file.text()? })
            })?,
            scenario: files.read("scenario", &settings.scenario, scenario::of_mission)?.unwrap_or_default(),
            weather: weather.or_else(|| forecast.clone()).unwrap_or_default(),
            forecast: forecast.unwrap_or_default(),
            forecasts,
            clouds: files.read("cloud-forecast", &settings.cloud_forecast, clouds::read)?.unwrap_or_default(),
            failure: settings.failure,
            start: Position::default(),
            start_altitude_m: 0.0,
            modems: Vec::new(),
            link_map: Vec::new(),
            weak_targets: Vec::new(),
            lost_link: lost_link::LostLink::default(),
            data: Arc::default(),
            library,
            settings,
            model,
            targets,
            airfields,
            terrain,
            highest_ground_m: f64::NEG_INFINITY,
        };
        (mission.start, mission.start_altitude_m) = mission.start_place()?;
        mission.highest_ground_m = mission.ground_between_m();
        mission.check_ceiling()?;
        mission.modems = modems::read(&mission)?;
        mission.read_links()?;
        mission.check_start()?;
        mission.data = Arc::new(files.data);
        Ok(mission)
    }

    /// Reads the assumptions about radio links and the response to a lost link.
    fn read_links(&mut self) -> MissionResult {
        let place_of = |value: &Value| self.place(value);
        let stations = self.modems.iter().filter_map(|modem| Some((modem.name.clone(), modem.level.station?)));
        let links = link_map::read((&self.settings.link_map, self.settings.place_of("link-map")), &place_of, stations)?;
        let lost = lost_link::read((&self.settings.lost_link, self.settings.place_of("lost-link")), Some(&place_of))?;
        (self.link_map, self.lost_link) = (links, lost);
        Ok(())
    }

    /// Checks that the requirements hold at the start.
    fn check_start(&self) -> MissionResult {
        let is_option = self.settings.option_places.iter().any(|(name, _)| name == "landing-distance");
        let landing_option = if is_option { "landing-distance" } else { "requirements" };
        requirements::check_start(&requirements::StartConditions {
            place: self.settings.place_of("requirements"),
            requirements: &self.requirements,
            model: &self.model,
            zones: &self.zones,
            landing_places: self.landing_places(),
            forecast: &self.forecast,
            duration_s: self.settings.duration.seconds(),
            landing_place: self.settings.place_of(landing_option),
            circle_m: 2.0 * self.model.turns.circle_width * vehicle::turn_radius_m(&self.model),
            start: self.start,
            start_altitude_m: self.start_altitude_m,
        })
    }

    /// Checks that the start lies below the vehicle's ceiling, and the cruise altitude not above it.
    fn check_ceiling(&self) -> MissionResult<()> {
        let (ceiling_m, cruise_m) = (self.model.ceiling_m, self.cruise_altitude_m());
        let too_low = |what: String, altitude_m: f64| {
            MissionError::vehicle(format!("the vehicle `{}` cannot fly this mission", self.model.name))
                .because(format!(
                    "{what} is at {altitude_m:.0} m and its ceiling, `flight.ceiling_m`, at {ceiling_m:.0} m"
                ))
                .help("choose another vehicle, or correct the elevation")
        };
        if self.start_altitude_m >= ceiling_m {
            return Err(too_low(format!("its start `{}`", self.settings.start), self.start_altitude_m));
        }
        if cruise_m > ceiling_m {
            return Err(too_low("its cruise above the highest ground of the mission".to_string(), cruise_m));
        }
        Ok(())
    }

    fn start_place(&self) -> MissionResult<(Position, f64)> {
        let start = &self.settings.start;
        let found = self.place(start).map(|(position, stated_m)| {
            let stated_m = (stated_m != 0.0).then_some(stated_m);
            let ground_m = terrain::elevation_m(self.terrain.as_deref(), position, stated_m);
            let ground_m = ground_m
                .map_err(|mismatch| mismatch.error(&format!("the start `{start}`"), self.settings.place_of("vehicle")));
            ground_m.map(|ground_m| (position, ground_m))
        });
        found.transpose()?.ok_or_else(|| {
            let names: Vec<&str> = self.place_names().take(12).collect();
            MissionError::setting(format!("the vehicle's start `:at {start}` is not a place"))
                .at(self.settings.place_of("vehicle"))
                .help(format!("write a location (LATITUDE LONGITUDE) or one of: {}", names.join(", ")))
        })
    }

    /// Returns the highest ground of the terrain in the box around all places, with space for turns.
    fn ground_between_m(&self) -> f64 {
        let room_m = self.ground_room_m();
        let places = self.targets.iter().map(|target| target.position).chain([self.start]);
        let places: Vec<Position> = places.chain(self.airfields.iter().map(|field| field.position)).collect();
        let corners =
            |place: &Position| [45.0, 225.0].map(|azimuth_deg| geodesy::destination(*place, azimuth_deg, 1.5 * room_m));
        let around: Vec<Position> = places.iter().flat_map(corners).collect();
        let found = self.terrain.as_ref().zip(geodesy::bounding_area(&around));
        found.and_then(|(terrain, area)| terrain.highest_m_in(&area)).unwrap_or(f64::NEG_INFINITY)
    }

    /// Returns the space for turns around a place.
    pub(crate) fn ground_room_m(&self) -> f64 {
        ROOM_M_MIN.max(ROOM_RADII * vehicle::turn_radius_m(&self.model))
    }

    /// Returns the lowest altitude that keeps the terrain clearance within `reach_m` of a place and its turns; `None` without known ground.
    pub(crate) fn clear_altitude_m(&self, position: Position, reach_m: f64) -> Option<f64> {
        let highest_m = self.terrain.as_ref()?.highest_m_near(position, reach_m + self.ground_room_m())?;
        Some(highest_m + self.requirements.terrain_clearance_m.unwrap_or(0.0))
    }

    /// Returns the altitude above mean sea level of flights between targets.
    pub fn cruise_altitude_m(&self) -> f64 {
        let targets = self.targets.iter().map(|target| target.elevation_m + target.height_m);
        let fields = self.airfields.iter().map(|airfield| airfield.elevation_m);
        let highest_m = targets.chain(fields).fold(self.start_altitude_m, f64::max);
        let cruise = &self.model.planning.cruise;
        // The altitude is above all ground if the vehicle can reach it; otherwise routes go around higher ground.
        let over_all_m = cruise.altitude_m(highest_m.max(self.highest_ground_m));
        if over_all_m <= self.model.planning.ceiling_share * self.model.ceiling_m {
            over_all_m
        } else {
            cruise.altitude_m(highest_m)
        }
    }

    fn place_names(&self) -> impl Iterator<Item = &str> {
        let airfields = self.airfields.iter().map(|airfield| airfield.id.as_str());
        airfields.chain(self.targets.iter().map(|target| target.id.as_str()))
    }

    /// Returns the position of a location value, or of the airfield or target of a name, with its altitude above mean sea level.
    pub fn place(&self, value: &apex_model::value::Value) -> Option<(Position, f64)> {
        if let Some(Location { position, altitude_m }) = Location::from_value(value) {
            return possible(position).then_some((position, altitude_m));
        }
        let name = value.as_symbol()?.folded();
        let airfield = self.airfields.iter().find(|airfield| airfield.id == name);
        let target = self.targets.iter().find(|target| target.id == name);
        airfield
            .map(|airfield| (airfield.position, airfield.elevation_m))
            .or_else(|| target.map(|target| (target.position, target.elevation_m)))
    }

    /// Returns the emergency landing places: all airfields and bases.
    pub fn landing_places(&self) -> Vec<LandingPlace> {
        let airfields = self.airfields.iter().map(|airfield| (&airfield.id, airfield.position));
        let bases = self.targets.iter().filter(|target| matches!(target.kind, TargetKind::Base));
        airfields
            .chain(bases.map(|base| (&base.id, base.position)))
            .map(|(name, position)| LandingPlace { name: name.clone(), position })
            .collect()
    }

    /// Returns the reason for which plans leave a target out, if its link is weak.
    pub fn weak_reason(&self, target: &str) -> Option<&str> {
        self.weak_targets.iter().find(|(known, _)| known == target).map(|(_, reason)| reason.as_str())
    }

    /// Returns a short name for files: that of the folder of a `mission.pdl`, or the name of another program file without its extension.
    pub fn short_name(path: &Path) -> String {
        let program = program::program_path(path);
        let absolute = std::fs::canonicalize(&program).unwrap_or(program);
        let of_folder = absolute.parent().and_then(Path::file_name);
        let name = if absolute.file_name().is_some_and(|name| name == "mission.pdl") {
            of_folder
        } else {
            absolute.file_stem()
        };
        name.map_or_else(|| "mission".to_string(), |name| name.to_string_lossy().into_owned())
    }
}

/// Reads a file of winds, in the format of a mission's `:weather`.
///
/// # Errors
/// If the file cannot be read, or does not describe winds.
pub fn read_wind(path: &Path) -> MissionResult<WindField> {
    let bytes = files::read_bytes(path)?;
    surroundings::wind(&DataFile { place: path.display().to_string(), bytes })
}

/// Space for turns around a place, in turn radii; also for vehicles that turn on the spot.
const ROOM_RADII: f64 = 3.0;
const ROOM_M_MIN: f64 = 50.0;

fn possible(position: Position) -> bool {
    position.latitude_deg.abs() <= 90.0 && position.longitude_deg.abs() <= 180.0
}

/// Reads the data files that the application names, and keeps their bytes for the record.
struct Files<'a> {
    sources: &'a Sources,
    /// Returns the place of an option of the application in the program.
    place_of: &'a dyn Fn(&str) -> String,
    data: Vec<(String, Vec<u8>)>,
}

impl Files<'_> {
    /// Returns the ground of these files; `None` without any.
    fn terrain(&mut self, names: &[String]) -> MissionResult<Option<Arc<Terrain>>> {
        let mut grids = Vec::new();
        for name in names {
            grids.extend(self.read("terrain", &Some(name.clone()), terrain::grid)?);
        }
        Ok(Terrain::new(grids).map(Arc::new))
    }

    /// Returns the forecasts of these files with their names.
    fn forecasts(&mut self, names: &[String]) -> MissionResult<Vec<(String, WindField)>> {
        let mut forecasts = Vec::new();
        for name in names {
            let wind = self.read("forecast", &Some(name.clone()), surroundings::wind)?;
            forecasts.push((name.clone(), wind.unwrap_or_default()));
        }
        Ok(forecasts)
    }

    fn read<T>(
        &mut self,
        option: &str,
        name: &Option<String>,
        read: impl Fn(&DataFile) -> MissionResult<T>,
    ) -> MissionResult<Option<T>> {
        let Some(name) = name else { return Ok(None) };
        let place = || format!("{} names it as `:{option} \"{name}\"`", (self.place_of)(option));
        let file = self.sources.read(name, place)?;
        let read = read(&file)?;
        if !self.data.iter().any(|(known, _)| known == name) {
            self.data.push((name.clone(), file.bytes));
        }
        Ok(Some(read))
    }
}
