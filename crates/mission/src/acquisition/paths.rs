//! The function that returns the points of a manoeuvre to PDL: `(manoeuvre-path FORM TARGET CAMERA SPEED MET
//! [STEPS])`.
//!
//! Its result depends only on its arguments and the mission's data, so a replay gets the same result. Bound: O(points).

use super::modes::{Modes, at_interval, check_sight, manoeuvre_of_form};
use super::permitted::{PathRequirements, PlacedPath};
use super::sweep_form::SweptGround;
use super::vehicle::{craft_of, instrument_of, scene_of};
use crate::Mission;
use crate::downlink::StatedDownlink;
use crate::observing::carries_scanner;
use crate::vehicle::VehicleModel;
use apex_geo::geodesy;
use apex_geo::location::Location;
use apex_model::host::HostFunctions;
use apex_model::problem::{Position, WindField};
use apex_model::quantity::Dimension;
use apex_model::time::Duration;
use apex_model::value::Value;
use apex_observation::manoeuvres::{
    AttitudeMode, Craft, DataHandling, Element, FlightPath, Instrument, Manoeuvre, PacedPoint, PayloadUse, Refusal,
    Scene, Sight, SpeedProfile, Track,
};
use std::sync::Arc;

/// Points nearer to each other than this are one.
const SAME_M: f64 = 0.01;

/// Data of a mission that the function needs.
pub(crate) struct Places {
    model: VehicleModel,
    wind: WindField,
    requirements: PathRequirements,
    downlink: Option<StatedDownlink>,
    targets: Vec<Place>,
}

/// A target, or a place.
#[derive(Clone, Debug)]
struct Place {
    /// Name in lower case; the location for a place.
    name: String,
    position: Position,
    /// Level of the observed part.
    elevation_m: f64,
    /// Elevation of the ground.
    ground_m: f64,
    /// Corners of its ground, metres east and north; none for a point.
    corners: Vec<(f64, f64)>,
}

/// Returns the manoeuvre that PDL flies: along a path in its modes with a camera (or the scanner), at a speed.
pub(crate) fn manoeuvre_of(
    (path, modes): (FlightPath, Modes),
    speed_mps: Option<f64>,
    data: DataHandling,
    (craft_hovers, scans): (bool, bool),
) -> Manoeuvre {
    let (attitude, speed) = (modes.attitude_of(&path, craft_hovers), modes.speed_of(speed_mps, craft_hovers));
    let payload = if scans { PayloadUse::LineScan } else { PayloadUse::Video };
    Manoeuvre { path, attitude, speed, payload, data }
}

/// Replaces `manoeuvre-path`, which fails without a mission, by the function with the mission's data.
pub(crate) fn register(mission: &Mission, functions: &mut HostFunctions) {
    let targets = mission.targets.iter();
    let places = Arc::new(Places {
        model: mission.model.clone(),
        wind: mission.forecast.clone(),
        requirements: PathRequirements::of(mission),
        downlink: mission.settings.downlink,
        targets: targets
            .map(|target| Place {
                name: target.id.to_lowercase(),
                position: target.position,
                elevation_m: super::vehicle::elevation_m(target),
                ground_m: target.elevation_m,
                corners: super::vehicle::target_corners(target),
            })
            .collect(),
    });
    let function =
        move |arguments: &[Value]| places.points(arguments).map_err(|reason| format!("`manoeuvre-path`: {reason}"));
    functions.register("manoeuvre-path", Arc::new(function));
}

impl Places {
    /// Returns `(POINTS SPEEDS SPEED BEGIN AIM LOOKS DWELL NOSE DATA)`: points with altitudes; the ground speed at each, of a fixed wing its
    /// airspeed, or nil if that is constant; the airspeed; `hover`, `line` or `stand` (a hover is all) as the kind of beginning; `down`, the
    /// target or `(along AZIMUTH TILT)` as the aim of the camera; pairs of a heading and a place for the camera to point at from a hover; the
    /// time for each; and the option `:nose` of the flight command, if the manoeuvre demands a direction of the nose;
    /// the option `:data` of commands to the payload, if the form states it.
    fn points(&self, arguments: &[Value]) -> Result<Value, String> {
        let ([form, target, camera, speed, met], steps) = match arguments {
            [form, target, camera, speed, met] => ([form, target, camera, speed, met], None),
            [form, target, camera, speed, met, steps] => ([form, target, camera, speed, met], Some(steps)),
            _ => return Err(format!("it takes 5 or 6 arguments and was given {}", arguments.len())),
        };
        let Place { name: target_name, position: place, elevation_m, ground_m, corners } = self.place(target)?;
        let speed_mps = speed_of(speed)?;
        let at_s = met.as_number().map_or(0.0, |(seconds, _)| seconds);
        let name = camera.as_symbol().map(|name| name.folded().to_string());
        let instrument = instrument_of(&self.model, name.as_deref())?;
        let ground = SweptGround { target: &target_name, corners: &corners, instrument: &instrument };
        let (path, modes) = manoeuvre_of_form(form, &ground)?;
        if steps.is_some() && matches!(path, FlightPath::Pirouette(_)) {
            return Err(format!(
                "a pirouette takes one picture in each direction, at no distance or time from another: write `(look around {target} by \
                 {form} with {camera})`"
            ));
        }
        let height_m = height_m(&path);
        let craft = craft_of(&self.model, elevation_m + height_m);
        let scene = scene_of((place, elevation_m), &self.wind, height_m, place, at_s);
        let scans = matches!(instrument, Instrument::Scanner(_)) && carries_scanner(&self.model);
        let data = modes.data_over(self.downlink.as_ref())?;
        let manoeuvre = manoeuvre_of((path, modes), speed_mps, data, (craft.can_hover, scans));
        let payload = steps.and_then(payload_of).filter(|_| !scans).unwrap_or(manoeuvre.payload);
        let manoeuvre = Manoeuvre { payload, ..manoeuvre };
        let instrument = at_interval(instrument, &manoeuvre.payload);
        let refused = |refusal: Refusal| refusal.to_string();
        check_sight(&manoeuvre, &craft, &instrument)?;
        let track = manoeuvre.track(&craft, &instrument, &scene).map_err(refused)?;
        // The link must carry the pictures at the speeds of the path.
        manoeuvre.timed(&craft, &instrument, &scene).map_err(refused)?;
        let (paced, speeds, airspeed) = paced(&manoeuvre, &track, &craft, (&instrument, &scene)).map_err(refused)?;
        let aim = aim(track.sight, target);
        // A camera that does not pan turns the nose itself.
        let nose = match (manoeuvre.attitude, track.sight) {
            (AttitudeMode::Fixed { heading_deg }, _) => Some(Value::Real(heading_deg)),
            (AttitudeMode::Pointing, Sight::Down) if craft.can_hover => Some(value_of(place, elevation_m)),
            _ => None,
        };
        let placed = |(point, height_m)| (scene.position(point), scene.elevation_m + height_m);
        let points: Vec<(Position, f64)> = match paced.is_empty() {
            true => track.points().map(|point| placed((point.point, point.height_m))).collect(),
            false => paced.iter().map(|point| placed((point.point, point.height_m))).collect(),
        };
        let legs = points.iter().zip(points.iter().skip(1));
        let length_m: f64 = legs.map(|((from, _), (to, _))| geodesy::distance_m(*from, *to)).sum();
        let span_s = (at_s, at_s + length_m / craft.true_airspeed_mps);
        let (name, points_of) = (manoeuvre.path.name(), points.as_slice());
        let flown = PlacedPath { name, points: points_of, height_m, target_m: elevation_m, ground_m, span_s };
        self.requirements.check(&flown).map_err(refused)?;
        let points: Vec<Value> = points.iter().map(|(position, altitude_m)| value_of(*position, *altitude_m)).collect();
        let begin = match (craft.can_hover, track.sight) {
            (false, _) => "line",
            (true, Sight::Target) if paced.is_empty() => "stand",
            (true, _) => "hover",
        };
        let begin = Value::symbol(begin);
        let speeds = Value::list(speeds.into_iter().map(|speed| Value::measured(speed, Dimension::SPEED)));
        let nose = Value::list(nose.into_iter().flat_map(|nose| [Value::symbol(":nose"), nose]));
        let airspeed = Value::measured(airspeed, Dimension::SPEED);
        let looks = Value::list(aims(&track.elements, track.sight, &scene, height_m));
        let dwell_s = track.elements.iter().find_map(|element| match element {
            Element::Hover { dwell_s, .. } => Some(*dwell_s),
            Element::Follow { .. } => None,
        });
        let dwell = Value::Duration(Duration::from_seconds(dwell_s.unwrap_or(0.0)));
        let data = modes.data.into_iter().flat_map(|data| [Value::symbol(":data"), data.value()]);
        Ok(Value::list([Value::list(points), speeds, airspeed, begin, aim, looks, dwell, nose, Value::list(data)]))
    }

    fn place(&self, value: &Value) -> Result<Place, String> {
        let name = match value {
            Value::Symbol(symbol) => symbol.folded().to_string(),
            Value::Text(text) => text.to_lowercase(),
            _ => {
                let Location { position, altitude_m } = Location::of(value)?;
                let elevation_m = altitude_m.unwrap_or(0.0);
                let name = value.to_string();
                return Ok(Place { name, position, elevation_m, ground_m: elevation_m, corners: Vec::new() });
            }
        };
        let found = self.targets.iter().find(|target| target.name == name);
        let known = || self.targets.iter().map(|target| target.name.as_str()).collect::<Vec<_>>().join(", ");
        found.cloned().ok_or_else(|| format!("the mission has no target `{name}`; it has {}", known()))
    }
}

/// Reads a speed; `None` for nil.
fn speed_of(value: &Value) -> Result<Option<f64>, String> {
    match value.as_number() {
        Some((speed, Dimension::SPEED | Dimension::NONE)) if speed.is_finite() && speed > 0.0 => Ok(Some(speed)),
        None if !value.is_true() => Ok(None),
        _ => Err(format!("the speed {value} is not a speed")),
    }
}

/// Returns the followed points, the ground speed at each (of a fixed wing its airspeed; empty if that is constant), and the airspeed.
///
/// # Errors
/// A speed that vehicle or wind do not permit.
fn paced(
    manoeuvre: &Manoeuvre,
    track: &Track,
    craft: &Craft,
    (instrument, scene): (&Instrument, &Scene),
) -> Result<(Vec<PacedPoint>, Vec<f64>, f64), Refusal> {
    let mut paced = manoeuvre.paced_points(craft, instrument, scene)?;
    if !craft.can_hover {
        // A fixed wing cannot change its speed within a line: the points of the path itself remain.
        paced.retain(|paced| track.points().any(|point| point.point.minus(paced.point).length() < SAME_M));
    }
    let fastest = paced.iter().map(|point| point.true_airspeed_mps).fold(0.0, f64::max);
    let (speeds, airspeed) = match manoeuvre.speed {
        SpeedProfile::Airspeed(airspeed_mps) if !craft.can_hover => (Vec::new(), airspeed_mps),
        _ if !craft.can_hover => (paced.iter().map(|point| point.true_airspeed_mps).collect(), fastest),
        _ => {
            let speeds = paced.iter().map(|point| point.speed_mps).collect();
            (speeds, (fastest + 0.5).min(craft.true_airspeed_mps_max))
        }
    };
    Ok((paced, speeds, airspeed))
}

/// Reads the steps between pictures, `(:every DISTANCE)` or `(:interval TIME)`; `None` for other values.
fn payload_of(steps: &Value) -> Option<PayloadUse> {
    let [key, figure] = steps.as_list()? else { return None };
    let (figure, _) = figure.as_number().filter(|(figure, _)| figure.is_finite() && *figure > 0.0)?;
    match key.as_symbol()?.folded() {
        ":every" => Some(PayloadUse::StillsEvery(figure)),
        ":interval" => Some(PayloadUse::StillsInterval(figure)),
        _ => None,
    }
}

/// Returns the height of a path over its target.
pub(crate) fn height_m(path: &FlightPath) -> f64 {
    match path {
        FlightPath::StraightOver(path) => path.height_m,
        FlightPath::StandOff(path) => path.height_m,
        FlightPath::Spiral(path) => path.height_m,
        FlightPath::Arc(path) => path.overhead_m(),
        FlightPath::Sweep(path) => path.height_m,
        FlightPath::Pirouette(path) => path.height_m,
        FlightPath::Strafe(path) => path.height_m,
        FlightPath::Orbit(path) => path.height_m,
        FlightPath::VantagePoint(path) => path.height_m(),
        FlightPath::ExpandingSquare(path) => path.height_m,
        FlightPath::SectorSearch(path) => path.height_m,
    }
}

/// Returns the direction of the camera in the notation of `orient`.
fn aim(sight: Sight, target: &Value) -> Value {
    match sight {
        Sight::Down => Value::symbol("down"),
        Sight::Direction { azimuth_deg, tilt_deg } => {
            Value::list([Value::symbol("along"), Value::Real(azimuth_deg), Value::Real(tilt_deg)])
        }
        Sight::Target | Sight::Nose { .. } => target.clone(),
    }
}

fn location(scene: &Scene, point: apex_geo::plane::Point, height_m: f64) -> Value {
    value_of(scene.position(point), scene.elevation_m + height_m)
}

fn value_of(Position { latitude_deg, longitude_deg }: Position, altitude_m: f64) -> Value {
    Value::list([latitude_deg, longitude_deg, altitude_m].map(Value::Real))
}

/// Returns, for each heading of the hovers, the heading and the place that the camera points at; empty unless the nose points the camera.
fn aims(elements: &[Element], sight: Sight, scene: &Scene, height_m: f64) -> Vec<Value> {
    let Sight::Nose { tilt_deg } = sight else { return Vec::new() };
    let away_m = height_m / libm::tan(-tilt_deg * apex_geo::geodesy::RAD_PER_DEG).max(1e-3);
    let place = |heading_deg: &f64| {
        let azimuth_rad = heading_deg * apex_geo::geodesy::RAD_PER_DEG;
        let point = apex_geo::plane::Point { x: away_m * libm::sin(azimuth_rad), y: away_m * libm::cos(azimuth_rad) };
        Value::list([Value::Real(*heading_deg), location(scene, point, 0.0)])
    };
    let hovers = elements.iter().filter_map(|element| match element {
        Element::Hover { headings_deg, .. } => Some(headings_deg),
        Element::Follow { .. } => None,
    });
    hovers.flatten().map(place).collect()
}
