//! The state packet: the published variables, their units, their intervals, and the making of a packet.

use crate::atmosphere::{Air, GRAVITY, ICE_K};
use crate::camera::Camera;
use crate::geodesic::bearing;
use crate::gusts::Gusts;
use crate::instants;
use crate::motion::{State, endurance_s};
use crate::phase::Phase;
use crate::radio::Radio;
use apex_geo::geodesy::{self, RAD_PER_DEG, wrap_180};
use apex_geo::wind::Wind;
use apex_model::event::{EventKind, StateVariable};
use apex_model::problem::Position;
use apex_model::quantity::{Dimension, Quantity, UNITS};
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::ports::Input;
use apex_vehicle::{EnergyModel, VehicleModel};
use libm::{atan2, cos, sqrt};
use std::collections::BTreeMap;

/// Rate at which a variable is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// In every packet, and every 0.2 s in flight while the scanner is on or a camera points or takes pictures.
    Attitude,
    /// In every packet.
    Fast,
    /// In full packets: at least every ten seconds.
    Slow,
    /// Sent in full packets, and in every packet in which it differs by more than [`CHANGE_SHARE`] from its last report, because readers
    /// may integrate the last report over time.
    Flow,
    /// On change, and in full packets.
    Discrete,
}

/// Relative change since its last report at which a [`Pace::Flow`] is reported again.
const CHANGE_SHARE: f64 = 0.01;

/// A state variable that the vehicle publishes.
#[derive(Clone, Copy, Debug)]
pub struct PublishedVariable {
    /// The attribute; the object is the vehicle's name.
    pub name: &'static str,
    /// The unit in which its values are printed; `None` for words, lists, durations and plain numbers.
    pub unit: Option<&'static str>,
    /// Rate of reports.
    pub pace: Pace,
    read: Read,
}

#[derive(Clone, Copy, Debug)]
enum Read {
    Number(fn(&Snapshot) -> f64),
    Other(fn(&Snapshot) -> Value),
    Word(fn(&Snapshot) -> &'static str),
}

/// Everything that a packet is read from.
pub(crate) struct Snapshot<'a> {
    pub(crate) state: &'a State,
    pub(crate) model: &'a VehicleModel,
    pub(crate) wind: Wind,
    pub(crate) air: Air,
    pub(crate) ground_m: f64,
    pub(crate) phase: Phase,
    pub(crate) distance_to_go_m: f64,
    pub(crate) altitude_m_commanded: f64,
    pub(crate) true_airspeed_commanded: f64,
    pub(crate) home: Position,
    /// None: no scanner on board.
    pub(crate) scanner_on: Option<bool>,
    pub(crate) scan_valid: bool,
    pub(crate) footprint_m: f64,
    /// Clouds hide the ground below.
    pub(crate) hidden: bool,
    pub(crate) gusts: &'a Gusts,
}

const fn number(name: &'static str, unit: &'static str, pace: Pace, read: fn(&Snapshot) -> f64) -> PublishedVariable {
    PublishedVariable { name, unit: Some(unit), pace, read: Read::Number(read) }
}

const fn plain(name: &'static str, pace: Pace, read: fn(&Snapshot) -> f64) -> PublishedVariable {
    PublishedVariable { name, unit: None, pace, read: Read::Number(read) }
}

const fn other(name: &'static str, pace: Pace, read: fn(&Snapshot) -> Value) -> PublishedVariable {
    PublishedVariable { name, unit: None, pace, read: Read::Other(read) }
}

const fn word(name: &'static str, read: fn(&Snapshot) -> &'static str) -> PublishedVariable {
    PublishedVariable { name, unit: None, pace: Pace::Discrete, read: Read::Word(read) }
}

fn truth_word(truth: bool) -> &'static str {
    if truth { "t" } else { "nil" }
}

/// Returns true for a variable of the vehicle whose value is a number.
pub(crate) fn is_number(name: &str) -> bool {
    let found = VARIABLES.iter().find(|variable| variable.name.eq_ignore_ascii_case(name));
    found.is_some_and(|variable| matches!(variable.read, Read::Number(_)))
}

use Pace::{Attitude, Fast, Flow, Slow};

/// Every variable of the vehicle, in the order of the packet. Cameras and modems add their own:
/// `(camera-state C)` `(camera-tilt C)` `(camera-pan C)` `(signal-level M)`.
pub const VARIABLES: &[PublishedVariable] = &[
    number("latitude", "deg", Fast, |s| s.state.position.latitude_deg * RAD_PER_DEG),
    number("longitude", "deg", Fast, |s| s.state.position.longitude_deg * RAD_PER_DEG),
    number("altitude", "m", Attitude, |s| s.state.altitude_m),
    number("height-above-ground", "m", Fast, |s| s.state.altitude_m - s.ground_m),
    other("location", Attitude, |s| location(s.state)),
    number("ground-speed", "m/s", Fast, |s| s.state.ground_speed()),
    number("true-airspeed", "m/s", Fast, |s| s.state.true_airspeed),
    number("vertical-speed", "m/s", Fast, |s| s.state.vertical_speed),
    number("heading", "deg", Attitude, |s| s.state.heading_rad),
    number("track", "deg", Fast, |s| s.state.track_rad()),
    number("roll-angle", "deg", Attitude, |s| s.state.roll_rad),
    number("pitch-angle", "deg", Attitude, |s| s.state.pitch_rad),
    number("roll-rate", "deg/s", Fast, |s| s.state.roll_rate_rad_s),
    number("yaw-rate", "deg/s", Fast, |s| s.state.yaw_rate_rad_s),
    number("acceleration-normal", "m/s2", Fast, |s| GRAVITY / cos(s.state.roll_rad) + s.gusts.bump_m_s2),
    number("distance-to-go", "m", Fast, |s| s.distance_to_go_m),
    number("footprint-width", "m", Fast, |s| s.footprint_m),
    word("scan-valid", |s| truth_word(s.scan_valid)),
    number("indicated-airspeed", "m/s", Slow, indicated_airspeed),
    number("wind-speed", "m/s", Slow, |s| {
        sqrt(s.wind.east_mps * s.wind.east_mps + s.wind.north_mps * s.wind.north_mps)
    }),
    number("wind-direction", "deg", Slow, wind_from_rad),
    plain("edr", Slow, |s| s.wind.edr),
    plain("truth-edr", Slow, |s| s.wind.edr),
    number("truth-wind-east", "m/s", Slow, |s| s.wind.east_mps),
    number("truth-wind-north", "m/s", Slow, |s| s.wind.north_mps),
    number("truth-gust-along", "m/s", Slow, |s| s.gusts.along_m_s()),
    number("truth-gust-across", "m/s", Slow, |s| s.gusts.across_m_s()),
    number("truth-gust-up", "m/s", Slow, |s| s.gusts.up_m_s()),
    number("fuel", "kg", Slow, |s| s.state.stored),
    number("fuel-flow", "kg/h", Flow, |s| s.state.drain_per_s),
    plain("battery-charge", Slow, battery_charge),
    number("battery-power", "W", Flow, |s| s.state.drain_per_s),
    other("endurance-remaining", Slow, endurance),
    number("commanded-altitude", "m", Slow, |s| s.altitude_m_commanded),
    number("commanded-speed", "m/s", Slow, |s| s.true_airspeed_commanded),
    number("ground-distance", "m", Slow, |s| bearing(s.home, s.state.position).1),
    number("distance-flown", "m", Slow, |s| s.state.distance_flown_m),
    other("flight-time", Slow, |s| Value::Duration(instants::span(s.state.flight_time_s))),
    number("outside-temperature", "K", Slow, |s| s.air.temperature_k),
    number("air-pressure", "hPa", Slow, |s| s.air.pressure_pa),
    plain("mach-number", Slow, |s| s.state.true_airspeed / s.air.sound_m_s()),
    word("flight-phase", |s| s.phase.word()),
    word("engine-state", |s| if s.state.engine_running { "running" } else { "stopped" }),
    word("on-ground", |s| truth_word(s.state.on_ground)),
    word("scanner-state", |s| match s.scanner_on {
        Some(true) if s.hidden => "obscured",
        Some(true) => "on",
        Some(false) => "off",
        None => "none",
    }),
];

/// Extent of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extent {
    /// Position and attitude, and the angles of cameras in use.
    Attitude,
    /// All variables that change fast.
    Fast,
    /// All variables.
    Full,
}

/// Longest time between samples of position and attitude while a sensor is in use, because images are located with them.
pub(crate) const ATTITUDE_S: f64 = 0.2;

/// Longest time without a full packet.
const FULL_S: f64 = 10.0;
/// Room for the inputs of a packet that is not full.
const INPUTS_BRIEF: usize = 16;

/// Returns the list published as `location`.
pub(crate) fn location(state: &State) -> Value {
    location_at(state.position, state.altitude_m)
}

/// Returns a place in the form in which `location` is published.
pub(crate) fn location_at(position: Position, altitude_m: f64) -> Value {
    let Position { latitude_deg, longitude_deg } = position;
    let degrees = |degrees: f64| rounded(degrees, POSITION_PER_DEG);
    let numbers = [degrees(latitude_deg), degrees(wrap_180(longitude_deg)), rounded(altitude_m, 100.0)];
    Value::List(numbers.map(Value::Real).into())
}

/// Rounds `number` to the nearest fraction of one with denominator `parts`; never returns minus zero.
pub(crate) fn rounded(number: f64, parts: f64) -> f64 {
    libm::round(number * parts) / parts + 0.0
}

/// A ten millionth of a degree is about a centimetre.
const POSITION_PER_DEG: f64 = 1e7;

/// Returns the number of parts into which a unit of a variable is rounded: finer than any sensor of the kind, and with few digits.
fn parts(variable: &PublishedVariable) -> f64 {
    match (variable.name, variable.unit) {
        ("latitude" | "longitude", _) => POSITION_PER_DEG,
        ("altitude" | "height-above-ground", _) => 100.0,
        (_, Some("m")) => 10.0,
        (_, Some("m/s" | "m/s2" | "kg" | "kg/h")) => 1e3,
        (_, Some("K" | "hPa")) => 100.0,
        _ => 1e4,
    }
}

/// Returns the share of the battery's capacity that is usable at the outside temperature.
fn battery_charge(snapshot: &Snapshot) -> f64 {
    let model = snapshot.model;
    model.available(snapshot.state.stored, snapshot.air.temperature_k - ICE_K) / model.stored_full()
}

fn is_changed(last: f64, now: f64) -> bool {
    (now - last).abs() > CHANGE_SHARE * last.abs() || last.is_nan()
}

/// Returns true if a vehicle with this store of energy has the variable.
fn is_carried(variable: &PublishedVariable, energy: &EnergyModel) -> bool {
    match energy {
        EnergyModel::Fuel(_) => !matches!(variable.name, "battery-charge" | "battery-power"),
        EnergyModel::Battery(_) => !matches!(variable.name, "fuel" | "fuel-flow"),
    }
}

fn endurance(snapshot: &Snapshot) -> Value {
    let seconds = endurance_s(snapshot.state, snapshot.model, snapshot.air.temperature_k - ICE_K);
    Value::Duration(Duration::from_seconds(libm::round(seconds)))
}

/// Returns the indicated airspeed; gusts along the flight count, because the pitot tube measures them.
fn indicated_airspeed(snapshot: &Snapshot) -> f64 {
    (snapshot.state.true_airspeed + snapshot.gusts.along_m_s()).max(0.0) / snapshot.air.true_per_indicated()
}

fn wind_from_rad(snapshot: &Snapshot) -> f64 {
    let Wind { east_mps, north_mps, .. } = snapshot.wind;
    if east_mps == 0.0 && north_mps == 0.0 {
        return 0.0;
    }
    geodesy::wrap_360(atan2(-east_mps, -north_mps) / RAD_PER_DEG) * RAD_PER_DEG
}

/// A variable with its name, unit and rounding, prepared once for all packets.
#[derive(Clone, Debug)]
struct Published {
    name: StateVariable,
    /// Zero in the unit of the variable.
    quantity: Quantity,
    /// SI value of one unit.
    factor: f64,
    /// Number of parts of one unit to which values are rounded.
    parts: f64,
    /// True if the vehicle has the variable.
    carried: bool,
}

impl Published {
    fn value(&self, si: f64) -> Value {
        let si = rounded(si / self.factor, self.parts) * self.factor;
        if self.quantity.unit.is_none() { Value::Real(si) } else { Value::Quantity(Quantity { si, ..self.quantity }) }
    }
}

/// Turns snapshots into inputs. Names and words are made once, to keep packets cheap.
#[derive(Clone, Debug)]
pub(crate) struct Reporter {
    variables: Vec<Published>,
    words: BTreeMap<&'static str, Value>,
    /// The last word reported of each discrete variable.
    last_words: Vec<&'static str>,
    /// The last number reported of each flow.
    last_flows: Vec<f64>,
    cameras: Vec<[StateVariable; 3]>,
    last_cameras: Vec<&'static str>,
    radios: Vec<StateVariable>,
    last_full: Option<Time>,
}

impl Reporter {
    pub(crate) fn new(vehicle: &str, model: &VehicleModel, cameras: &[Camera], radios: &[Radio]) -> Reporter {
        let object = Value::symbol(vehicle);
        let named = |variable: &PublishedVariable| {
            let quantity = template(variable.unit);
            Published {
                name: StateVariable::new(Symbol::new(variable.name), object.clone()),
                quantity,
                factor: quantity.unit().map_or(1.0, |unit| unit.factor),
                parts: parts(variable),
                carried: is_carried(variable, &model.energy),
            }
        };
        let of_camera = |camera: &Camera| {
            ["camera-state", "camera-tilt", "camera-pan"]
                .map(|name| StateVariable::new(Symbol::new(name), Value::symbol(&camera.model.name)))
        };
        let of_radio =
            |radio: &Radio| StateVariable::new(Symbol::new("signal-level"), Value::symbol(&radio.modem.name));
        Reporter {
            variables: VARIABLES.iter().map(named).collect(),
            words: BTreeMap::new(),
            last_words: vec![""; VARIABLES.len()],
            last_flows: vec![f64::NAN; VARIABLES.len()],
            cameras: cameras.iter().map(of_camera).collect(),
            last_cameras: vec![""; cameras.len()],
            radios: radios.iter().map(of_radio).collect(),
            last_full: None,
        }
    }

    /// Returns a packet at `at`; packets are full at least every ten seconds.
    pub(crate) fn packet(
        &mut self,
        at: Time,
        extent: Extent,
        snapshot: &Snapshot,
        cameras: &[Camera],
        radios: &[Radio],
        inputs: &mut Vec<Input>,
    ) {
        let old = self.last_full.is_none_or(|last| (at - last).seconds() >= FULL_S);
        let full = extent == Extent::Full || (extent == Extent::Fast && old);
        let brief = extent == Extent::Attitude;
        if full {
            self.last_full = Some(at);
            self.last_words.fill("");
            self.last_cameras.fill("");
        }
        inputs.reserve(if full { VARIABLES.len() } else { INPUTS_BRIEF });
        for ((variable, published), last_flow) in VARIABLES.iter().zip(&self.variables).zip(&mut self.last_flows) {
            let due = match (variable.pace, variable.read) {
                (Pace::Attitude, _) => true,
                (Pace::Fast, _) => !brief,
                (Pace::Slow, _) => full,
                (Pace::Flow, Read::Number(read)) => full || (!brief && is_changed(*last_flow, read(snapshot))),
                (Pace::Flow | Pace::Discrete, _) => false,
            };
            if !due || !published.carried {
                continue;
            }
            let value = match variable.read {
                Read::Number(read) => {
                    *last_flow = read(snapshot);
                    published.value(*last_flow)
                }
                Read::Other(read) => read(snapshot),
                Read::Word(_) => continue,
            };
            inputs.push(Input::new(at, EventKind::Measurement(published.name.clone(), value)));
        }
        self.changes(at, snapshot, cameras, inputs);
        let angle = || template(Some("deg"));
        let degrees = |rad: f64| rounded(rad / RAD_PER_DEG, 1e4) * RAD_PER_DEG;
        for (camera, [_, tilt, pan]) in
            cameras.iter().zip(&self.cameras).filter(|(camera, _)| full || camera.aim.is_some())
        {
            for (name, si) in [(tilt, camera.tilt_rad), (pan, camera.pan_rad)] {
                let value = Value::Quantity(Quantity { si: degrees(si), ..angle() });
                inputs.push(Input::new(at, EventKind::Measurement(name.clone(), value)));
            }
        }
        for (radio, name) in radios.iter().zip(&self.radios).filter(|_| !brief) {
            inputs.push(Input::new(at, EventKind::Measurement(name.clone(), Value::Real(rounded(radio.level, 1e4)))));
        }
    }

    /// Publishes the words that changed since they were last reported.
    pub(crate) fn changes(&mut self, at: Time, snapshot: &Snapshot, cameras: &[Camera], inputs: &mut Vec<Input>) {
        let words = &mut self.words;
        let mut publish = |name: &StateVariable, word: &'static str, last: &mut &'static str| {
            if word != *last {
                *last = word;
                let made = || if word == "nil" { Value::nil() } else { Value::symbol(word) };
                let value = words.entry(word).or_insert_with(made).clone();
                inputs.push(Input::new(at, EventKind::Measurement(name.clone(), value)));
            }
        };
        for ((variable, published), last) in VARIABLES.iter().zip(&self.variables).zip(&mut self.last_words) {
            if let Read::Word(read) = variable.read {
                publish(&published.name, read(snapshot), last);
            }
        }
        for ((camera, [name, ..]), last) in cameras.iter().zip(&self.cameras).zip(&mut self.last_cameras) {
            publish(name, camera.state.word(), last);
        }
    }
}

/// Returns a zero of `unit`, to be filled with numbers of SI units.
fn template(unit: Option<&str>) -> Quantity {
    let found = UNITS.iter().enumerate().find(|(_, known)| Some(known.name) == unit);
    match found {
        Some((index, known)) => Quantity { si: 0.0, dimension: known.dimension, unit: u8::try_from(index).ok() },
        None => Quantity { si: 0.0, dimension: Dimension::NONE, unit: None },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_asks_for_more_than_thirty_variables_and_each_unit_exists() {
        assert!(VARIABLES.len() > 30);
        for variable in VARIABLES {
            if let Some(unit) = variable.unit {
                assert!(UNITS.iter().any(|known| known.name == unit), "{unit}");
            }
        }
    }
}
