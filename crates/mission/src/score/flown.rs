//! Computes the observations of a flight from its batches.

use super::arrivals::Arrivals;
use super::deferred::{Addition, DeferredObservation};
use super::footprints::{FootprintLog, Footprints};
use super::growth::GrowthLog;
use super::samples::Latest;
use crate::ground::MissionGround;
use crate::observing::{camera_names, camera_of, looks_with, scanner_of};
use crate::situation::MissionUpdate;
use crate::{Mission, Site, Target, TargetKind};
use apex_model::event::{Batch, EventKind};
use apex_model::problem::Position;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_observation::attitude::Vector;
use apex_observation::flown::{FlightSample, FlownObservation, FlownSettings, Picture, SensorState};
use apex_observation::grid::GridSettings;
use apex_observation::result::TargetResult;
use apex_observation::sensor::camera::sight_of;
use apex_observation::sensor::{CameraSetting, ExposureMotion};
use apex_observation::strip::ScannerSetting;
use apex_observation::target::{ObservedTarget, TargetArea, WantedLook};
use apex_observation::timing::sun::solar_position;
use apex_portfolio::parallel::on_all_processors;
use std::collections::BTreeMap;
use std::sync::RwLockReadGuard;

/// Longest time between two samples across which the ground counts as seen.
const SAMPLE_GAP_S_MAX: f64 = 2.5;

/// Least vertical component of the sight line with which the distance from the camera to the ground is computed.
const STEEPNESS_MIN: f64 = 0.2;

/// Observations until now: a fold over the batches of a flight.
#[derive(Clone)]
pub struct FlownScore {
    observation: DeferredObservation,
    /// The fires, for outlines that are reported later.
    fires: std::sync::Arc<[Target]>,
    /// Outlines of fires that were reported before any of their ground was seen.
    outlines: BTreeMap<String, Vec<Position>>,
    /// Ground by which fires have grown since their ground was first seen.
    growth: GrowthLog,
    /// Setting of the scanner while it is on; `None` if the vehicle carries none.
    scanner: Option<ScannerSetting>,
    /// The cameras that the vehicle carries.
    cameras: Vec<CameraSetting>,
    /// Civil time of the mission's beginning; `None` if it is not stated: the position of the sun is then unknown.
    epoch_unix_s: Option<f64>,
    latest: Latest,
    arrivals: Arrivals,
    /// Footprints for maps; `None` unless they are collected instead of the score.
    footprints: Option<FootprintLog>,
}

/// Returns a site as a target of pictures: a point at the height of the structure, with one look of value 1.
fn of_site(target: &Target, site: &Site) -> ObservedTarget {
    ObservedTarget {
        name: target.id.clone(),
        area: TargetArea::Point(target.position),
        elevation_m: target.elevation_m + target.height_m,
        is_water: false,
        looks: vec![WantedLook::new("look", 1.0, site.resolution_m)],
        after: Vec::new(),
    }
}

/// Returns the observations until now, or the reason for which they are unknown.
pub(crate) fn told(flown: &Result<Option<FlownScore>, String>) -> Result<&FlownScore, &str> {
    match flown {
        Ok(Some(flown)) => Ok(flown),
        Ok(None) => Err("the mission has no target with a wanted observation"),
        Err(why) => Err(why),
    }
}

impl FlownScore {
    /// Returns a score without observations; `None` for a mission without targets that sensors observe.
    ///
    /// # Errors
    /// The ground of a target is invalid.
    pub fn new(mission: &Mission) -> Result<Option<FlownScore>, String> {
        let is_looked_at = looks_with(&mission.model).is_some();
        let wanted = mission.targets.iter().filter_map(|target| match &target.kind {
            TargetKind::Fire(fire) => Some(fire.wanted.clone()),
            TargetKind::Site(site) if is_looked_at => Some(of_site(target, site)),
            TargetKind::Site(_) | TargetKind::Plain | TargetKind::Base => None,
        });
        let wanted: Vec<_> = wanted.collect();
        if wanted.is_empty() {
            return Ok(None);
        }
        let lowest_m = wanted.iter().map(|target| target.elevation_m).fold(f64::INFINITY, f64::min);
        let (scanner, ground) = (scanner_of(&mission.model), MissionGround::new(mission.terrain.clone(), lowest_m));
        let settings = FlownSettings {
            zero_unix_s: mission.settings.epoch_unix_s.unwrap_or(0.0),
            grid: GridSettings::default(),
            sample_gap_s_max: SAMPLE_GAP_S_MAX,
        };
        let grid =
            |number: usize| wanted.get(number).map(|target| FlownObservation::grid_of(target, settings.grid, &ground));
        let grids = on_all_processors(wanted.len(), grid);
        let targets = wanted.into_iter().zip(grids.into_iter().flatten());
        let observation = FlownObservation::with_grids(targets, settings).map_err(|error| error.to_string())?;
        let scanner = scanner.map(|scanner| scanner.setting);
        let cameras =
            camera_names(&mission.model).into_iter().filter_map(|name| camera_of(&mission.model, name)).collect();
        let epoch_unix_s = mission.settings.epoch_unix_s;
        let fires = mission.targets.iter().filter(|target| target.outline().is_some()).cloned().collect();
        Ok(Some(FlownScore {
            observation: DeferredObservation::new(observation, ground),
            fires,
            outlines: BTreeMap::new(),
            growth: GrowthLog::default(),
            scanner,
            cameras,
            epoch_unix_s,
            latest: Latest::default(),
            arrivals: Arrivals::default(),
            footprints: None,
        }))
    }

    /// Collects footprints instead of the score from now on; the score takes a hundred times as long.
    #[must_use]
    pub fn only_footprints(self) -> FlownScore {
        FlownScore { footprints: Some(FootprintLog::default()), ..self }
    }

    /// Reads the reported positions instead of the true ones, which are not known on board while the navigation fails.
    #[must_use]
    pub fn as_known_on_board(mut self) -> FlownScore {
        self.latest.is_blind_to_truth = true;
        self
    }

    /// Returns the ground seen so far, including the present swath up to its last kept line; empty without
    /// [`FlownScore::only_footprints`].
    pub fn footprints(&self) -> Option<&Footprints> {
        self.footprints.as_ref().map(|log| &log.seen)
    }

    /// Takes the measurements of a batch of the agent that flies.
    pub fn observe(&mut self, batch: &Batch) {
        let mut pending: Option<Time> = None;
        for event in &batch.events {
            let (variable, value) = match &event.kind {
                EventKind::Measurement(variable, value) => (variable, value),
                EventKind::Occurrence(form) => {
                    self.occurrence(form, event.at);
                    continue;
                }
                _ => continue,
            };
            if pending.is_some_and(|at| at != event.at) {
                self.sample(pending.take());
            }
            if variable.attribute.is("on-ground") {
                let read = self.arrivals.on_ground(value.is_true(), event.at);
                read.into_iter().for_each(|product| self.observation.add(Addition::Product(product)));
            }
            let was_on = self.latest.is_on;
            if self.latest.take(variable, value, event.at) {
                pending = Some(event.at);
            }
            if was_on != self.latest.is_on {
                self.arrivals.switched(self.latest.is_on, event.at);
            }
            match (was_on, self.latest.is_on) {
                (false, true) => self.switch(),
                (true, false) => {
                    // The last sample still belongs to the line.
                    self.latest.is_on = true;
                    self.sample(pending.take());
                    self.latest.is_on = false;
                    self.switch();
                }
                _ => {}
            }
        }
        self.sample(pending);
    }

    /// Processes `(image-taken CAMERA TARGET)`: position, attitude and mount angles were reported just before. A picture that clouds hide
    /// (`image-obscured`) and one of a failed detector (`image-blank`) count as looks that are not clear.
    fn occurrence(&mut self, form: &Value, at: Time) {
        let Some([Value::Symbol(head), camera, ..]) = form.as_list() else { return };
        match head.folded() {
            "new-perimeter" => return self.grow(form),
            "crashed" => return self.arrivals.crashed(),
            "image-lost" => return self.arrivals.lost(&camera.to_string()),
            "image-kept" => return self.arrivals.kept(&camera.to_string()),
            "image-on-ground" => {
                let arrived = self.arrivals.arrived(&camera.to_string(), at);
                return arrived.into_iter().for_each(|product| self.observation.add(Addition::Product(product)));
            }
            _ => {}
        }
        let (is_obscured, is_blank) = (head.is("image-obscured"), head.is("image-blank"));
        if !(head.is("image-taken") || is_obscured || is_blank) {
            return;
        }
        let name = camera.to_string();
        let Some(camera) = self.cameras.iter().find(|camera| camera.name.eq_ignore_ascii_case(&name)).cloned() else {
            return;
        };
        if head.is("image-taken") {
            self.arrivals.taken(&name, at);
        }
        if let Some(mut picture) = self.picture(&camera, at) {
            if is_blank {
                picture.weights.ready = 0.0;
            }
            picture.sample.clear_share = if is_obscured { Some(0.0) } else { None };
            if let Some(log) = &mut self.footprints {
                log.picture(&picture, at, self.observation.now().elevation_m_near(picture.sample.position));
                return;
            }
            self.observation.change(|observation, ground| observation.picture(&picture, ground));
        }
    }

    /// `(new-perimeter TARGET OUTLINE)`: a fire of which no ground has been seen yet is judged by its outline from now on; ground by which
    /// another fire has grown becomes a separate target.
    fn grow(&mut self, form: &Value) {
        let Some(MissionUpdate::NewPerimeter(name, outline)) =
            form.as_list().and_then(|items| MissionUpdate::read("new-perimeter", items.get(1..)?))
        else {
            return;
        };
        let fires = std::sync::Arc::clone(&self.fires);
        let Some(fire) = fires.iter().find(|fire| fire.id == name) else { return };
        if self.observation.now().is_seen(&name) {
            let first = self.outlines.get(&name).cloned().or_else(|| fire.outline()).unwrap_or_default();
            let growth = &mut self.growth;
            self.observation.change(|observation, ground| {
                let is_seen = |part: &str| observation.is_seen(part);
                if let Some((target, grid)) = growth.take(fire, (first, outline), is_seen, ground) {
                    observation.put(target, grid);
                }
            });
            return;
        }
        let Some(area) = fire.area_within(&outline) else { return };
        // An outline that cannot be divided into cells changes nothing; planners ignore it too.
        let reshaped = self.observation.change(|observation, ground| observation.reshape(&name, area, ground));
        if reshaped.is_ok() {
            self.outlines.insert(name, outline);
        }
    }

    /// Returns the mission with the growth of its fires as further targets, with their present values.
    pub(crate) fn with_growth(&self, mission: Mission) -> Mission {
        self.growth.with_growth(mission)
    }

    /// Returns a picture as recorded; `None` if the position or the mount angles are unknown.
    fn picture(&mut self, camera: &CameraSetting, at: Time) -> Option<Picture> {
        self.latest.turn(at);
        let (position, altitude_m) = self.latest.place?;
        let angles = self.latest.angles(&camera.name)?;
        let attitude = self.latest.attitude(at);
        let sight = sight_of(&attitude.unwrap_or_default(), angles, camera.is_stabilised);
        let down = sight(Vector::new(1.0, 0.0, 0.0)).z.max(STEEPNESS_MIN);
        let sun_deg = self.epoch_unix_s.map(|zero| solar_position(position, zero + at.seconds()).elevation_deg);
        let ground_m = self.observation.now().elevation_m_near(position);
        let motion = ExposureMotion {
            roll_deg: attitude.map(|attitude| attitude.roll_deg),
            ground_speed_mps: self.latest.ground_speed_mps(at),
            rotation_rad_s: self.latest.rotation_rad_s(),
            slant_m: ((altitude_m - ground_m) / down).max(1.0),
            sun_deg,
        };
        Some(Picture {
            sample: self.flight_sample(at, position, altitude_m),
            angles,
            horizontal_field_deg: camera.wide_deg,
            vertical_field_deg: camera.high_deg,
            pixel_mrad: camera.pixel_mrad,
            is_stabilised: camera.is_stabilised,
            weights: camera.weights(&motion),
        })
    }

    fn flight_sample(&self, at: Time, position: Position, altitude_m: f64) -> FlightSample {
        FlightSample {
            time_s: at.seconds(),
            position,
            altitude_m,
            attitude: self.latest.attitude(at),
            ground_speed_mps: self.latest.ground_speed_mps(at),
            clear_share: self.latest.clear_share,
        }
    }

    /// Records that the scanner was switched on or off.
    fn switch(&mut self) {
        let state = match &self.scanner {
            Some(setting) if self.latest.is_on => SensorState::Scanning(setting.clone()),
            _ => SensorState::Off,
        };
        if let Some(log) = &mut self.footprints {
            log.end_swath();
        }
        self.observation.add(Addition::Sensor(state));
    }

    fn sample(&mut self, at: Option<Time>) {
        let Some(at) = at else { return };
        self.latest.turn(at);
        if !self.latest.is_on {
            return;
        }
        let Some((position, altitude_m)) = self.latest.place else { return };
        if let (Some(log), Some(setting)) = (&mut self.footprints, &self.scanner) {
            let ground_m = self.observation.now().elevation_m_near(position);
            log.line(&self.latest, setting, (at, ground_m, SAMPLE_GAP_S_MAX));
            return;
        }
        let sample = self.flight_sample(at, position, altitude_m);
        self.observation.add(Addition::Sample(sample));
    }

    /// True while the scanner is on.
    pub(super) fn is_scanning(&self) -> bool {
        self.latest.is_on
    }

    /// Returns the observations until now.
    pub(crate) fn observation(&self) -> RwLockReadGuard<'_, FlownObservation> {
        self.observation.now()
    }

    /// Returns true if a picture of the target between two instants has a value.
    pub fn saw(&self, target: &str, from_s: f64, until_s: f64) -> bool {
        self.observation.now().valid_looks_s(target).into_iter().any(|time_s| (from_s..=until_s).contains(&time_s))
    }

    /// Returns the result of the looks of one target; `None` while nothing of it has been seen.
    pub fn result(&self, target: &str) -> Option<TargetResult> {
        self.observation.now().result(target)
    }

    /// Returns the results of each target's looks.
    pub fn results(&self) -> Vec<TargetResult> {
        let observation = &*self.observation.now();
        let first_valid_s = observation.first_valid_s();
        let result = |number: usize| observation.result_of(number, &first_valid_s);
        on_all_processors(observation.target_count(), result).into_iter().flatten().collect()
    }
}
