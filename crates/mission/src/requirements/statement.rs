//! `:requirements ((airspace :horizontal 500m :vertical 150m) (terrain :clearance 300m) (energy :reserve 45min) ..)`

use crate::error::{MissionError, MissionResult};
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_requirements::margin::zone::ZoneBuffer;
use apex_vehicle::VehicleModel;

/// Required reach of a landing place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LandingReach {
    /// Within a distance.
    Disc {
        /// Greatest distance.
        distance_m_max: f64,
    },
    /// By gliding, arriving this high above the place.
    Gliding {
        /// Height of the landing pattern.
        pattern_m: f64,
    },
}

/// Requirements that an application states.
pub(crate) struct Stated<'a> {
    /// Place of the application, for errors.
    pub(crate) place: &'a str,
    /// The forms of `:requirements`.
    pub(crate) forms: &'a [Value],
    /// Greatest distance from a landing place, m.
    pub(crate) landing_distance_m_max: Option<f64>,
    /// Distance that flights between fires keep from zones, m.
    pub(crate) zone_margin_m: f64,
    /// Distance that flights between structures keep from obstacles, m.
    pub(crate) obstacle_margin_m: f64,
    /// Time before the end of the mission at which plans land; `None` where plans do not return.
    pub(crate) end_margin_s: Option<f64>,
}

/// The requirements of a mission. A requirement that is `None` is not stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Requirements {
    /// Distance that plans between fires keep from the edges of zones.
    pub zone_margin_m: f64,
    /// Distance that plans between structures keep from obstacles.
    pub obstacle_margin_m: f64,
    /// Distances that the flight keeps from zones; `None`: zones are not watched.
    pub airspace: Option<ZoneBuffer>,
    /// Clearance of the ground.
    pub terrain_clearance_m: Option<f64>,
    /// Nearness of a landing place.
    pub landing: Option<LandingReach>,
    /// Flight time that must remain at the nearest usable landing place.
    pub energy_reserve_s: Option<f64>,
    /// Time before the end of the mission at which the vehicle has landed at its base.
    pub landed_before_end_s: Option<f64>,
    /// Greatest turbulence: cube root of the eddy dissipation rate, m^(2/3)/s.
    pub edr_max: Option<f64>,
    /// Greatest wind.
    pub wind_mps_max: Option<f64>,
    /// Longest icing, in seconds of ice that the airframe carries.
    pub icing_s: Option<f64>,
    /// Longest time below the nominal level of a link.
    pub link_lost_s: Option<f64>,
    /// Greatest temperature of the detectors of cameras.
    pub heat: HeatLimit,
    /// Cameras stay off the sun; `None`: not watched.
    pub sun: Option<SunKeepOut>,
    /// Time over which violations are predicted.
    pub look_ahead_s: f64,
}

/// Distance of the fields of view of cameras from the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunKeepOut {
    /// Angle between field of view and sun; `None`: that of each sensor file.
    pub margin_deg: Option<f64>,
}

/// Greatest temperature of detectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeatLimit {
    /// The limit that each sensor file states.
    OfSensors,
    /// Not watched.
    Off,
    /// This limit, K.
    Kelvin(f64),
}

impl HeatLimit {
    /// Returns the limit in kelvin for a sensor whose file states `high_c`.
    pub fn limit_k(self, high_c: Option<f64>) -> Option<f64> {
        match self {
            HeatLimit::OfSensors => high_c.map(|high_c| high_c + 273.15),
            HeatLimit::Off => None,
            HeatLimit::Kelvin(limit_k) => Some(limit_k),
        }
    }
}

impl Requirements {
    /// Returns the greatest distance from a landing place, for planning problems.
    pub fn landing_distance_m_max(&self) -> Option<f64> {
        match self.landing {
            Some(LandingReach::Disc { distance_m_max }) => Some(distance_m_max),
            Some(LandingReach::Gliding { .. }) | None => None,
        }
    }
}

/// Default distances, in seconds of flight at cruise speed: 5 s from edges (476 m at 95 m/s, 60 m at 12 m/s), 1.5 s from faces, 3 s from
/// the ground.
const HORIZONTAL_S: f64 = 5.0;
const VERTICAL_S: f64 = 1.5;
const CLEARANCE_S: f64 = 3.0;
/// Share of the plan's margin that the flight must keep: wind and turns may use the rest.
const FLOWN_SHARE: f64 = 0.5;
/// Time margin before a zone becomes active, and after it ends.
const ZONE_TIME_S: f64 = 120.0;
/// Share of the plan's margin at the end of the mission that the flight keeps.
const LANDED_SHARE: f64 = 1.0 / 12.0;
const LOOK_AHEAD_S: f64 = 300.0;
const PATTERN_M: f64 = 300.0;
const LENGTH_M_MAX: f64 = 1e7;
const TIME_S_MAX: f64 = 30.0 * 86_400.0;
const SPEED_MPS_MAX: f64 = 1_000.0;
const DETECTOR_K_MAX: f64 = 1_000.0;

const USAGE: &str = "`:requirements ((airspace :horizontal 500m :vertical 150m :time 2min) (terrain :clearance 300m) (landing-distance :within 200km) \
    (energy :reserve 45min) (mission-end :before 5min) (turbulence :at-most 0.4) (wind :at-most 15m/s) \
    (icing :at-most 2min) (link :lost-for 30s) (heat :at-most 318K) (sun :margin 10deg) (look-ahead 5min))`; (NAME :off) takes a requirement out";

/// Returns the requirements of a mission with these settings and this vehicle. A requirement that the mission does not state has a
/// threshold derived from the vehicle's figures, or is not watched.
///
/// # Errors
/// A form of another shape, an unknown name or key, a figure of another unit or outside of its range, a requirement twice.
pub(crate) fn state(settings: &Stated<'_>, model: &VehicleModel) -> MissionResult<Requirements> {
    let mut requirements = of_vehicle(settings, model);
    let mut stated: Vec<&str> = Vec::new();
    for form in settings.forms {
        let Some([Value::Symbol(name), rest @ ..]) = form.as_list() else {
            return Err(wrong(
                settings,
                form,
                "expected a list that begins with the name of a requirement".to_string(),
            ));
        };
        let statement = Statement { settings, form, rest };
        if stated.contains(&name.folded()) {
            return Err(wrong(settings, form, format!("`{name}` is stated twice")));
        }
        stated.push(name.folded());
        statement.apply(name.folded(), &mut requirements)?;
    }
    Ok(requirements)
}

/// Returns the requirements before the mission states any.
fn of_vehicle(settings: &Stated<'_>, model: &VehicleModel) -> Requirements {
    let planned_margin_m = match settings.end_margin_s {
        Some(_) => settings.zone_margin_m,
        None => settings.obstacle_margin_m,
    };
    let cruise_mps = model.true_airspeed_m_s_cruise;
    Requirements {
        zone_margin_m: settings.zone_margin_m,
        obstacle_margin_m: settings.obstacle_margin_m,
        airspace: Some(ZoneBuffer {
            horizontal_m: (HORIZONTAL_S * cruise_mps).min(FLOWN_SHARE * planned_margin_m),
            vertical_m: VERTICAL_S * cruise_mps,
            time_s: ZONE_TIME_S,
        }),
        terrain_clearance_m: Some(CLEARANCE_S * cruise_mps),
        landing: settings.landing_distance_m_max.map(|distance_m_max| LandingReach::Disc { distance_m_max }),
        energy_reserve_s: Some(reserve_s(model)),
        landed_before_end_s: settings.end_margin_s.map(|margin_s| LANDED_SHARE * margin_s),
        edr_max: None,
        wind_mps_max: None,
        icing_s: None,
        link_lost_s: None,
        heat: HeatLimit::OfSensors,
        sun: Some(SunKeepOut { margin_deg: None }),
        look_ahead_s: LOOK_AHEAD_S,
    }
}

/// Returns the flight time that the vehicle's rule keeps in reserve.
fn reserve_s(model: &VehicleModel) -> f64 {
    model.reserve_s()
}

/// Returns the flight time that full energy allows at cruise.
pub(super) fn endurance_s(model: &VehicleModel) -> f64 {
    model.endurance_cruise_s()
}

/// One `(NAME KEY FIGURE ..)`.
struct Statement<'a> {
    settings: &'a Stated<'a>,
    form: &'a Value,
    rest: &'a [Value],
}

impl Statement<'_> {
    fn wrong(&self, why: String) -> MissionError {
        wrong(self.settings, self.form, why)
    }

    fn apply(&self, name: &str, requirements: &mut Requirements) -> MissionResult<()> {
        let is_off = matches!(self.rest, [Value::Symbol(word)] if word.is(":off"));
        match name {
            "airspace" if is_off => requirements.airspace = None,
            "airspace" => {
                let mut buffer =
                    requirements.airspace.unwrap_or(ZoneBuffer { horizontal_m: 0.0, vertical_m: 0.0, time_s: 0.0 });
                for (key, value) in self.pairs()? {
                    match key {
                        ":horizontal" => buffer.horizontal_m = self.figure(value, Dimension::LENGTH, LENGTH_M_MAX)?,
                        ":vertical" => buffer.vertical_m = self.figure(value, Dimension::LENGTH, LENGTH_M_MAX)?,
                        ":time" => buffer.time_s = self.figure(value, Dimension::TIME, TIME_S_MAX)?,
                        other => return Err(self.unknown(other, ":horizontal, :vertical, :time")),
                    }
                }
                requirements.airspace = Some(buffer);
            }
            "terrain" => {
                requirements.terrain_clearance_m = self.one(is_off, ":clearance", Dimension::LENGTH, LENGTH_M_MAX)?
            }
            "landing-distance" => requirements.landing = self.landing(is_off)?,
            "energy" => requirements.energy_reserve_s = self.one(is_off, ":reserve", Dimension::TIME, TIME_S_MAX)?,
            "mission-end" => {
                requirements.landed_before_end_s = self.one(is_off, ":before", Dimension::TIME, TIME_S_MAX)?
            }
            "turbulence" => requirements.edr_max = self.one(is_off, ":at-most", Dimension::NONE, 10.0)?,
            "wind" => requirements.wind_mps_max = self.one(is_off, ":at-most", Dimension::SPEED, SPEED_MPS_MAX)?,
            "icing" => requirements.icing_s = self.one(is_off, ":at-most", Dimension::TIME, TIME_S_MAX)?,
            "link" => requirements.link_lost_s = self.one(is_off, ":lost-for", Dimension::TIME, TIME_S_MAX)?,
            "heat" => {
                let limit_k = self.one(is_off, ":at-most", Dimension::TEMPERATURE, DETECTOR_K_MAX)?;
                requirements.heat = limit_k.map_or(HeatLimit::Off, HeatLimit::Kelvin);
            }
            "sun" => {
                let margin_rad = self.one(is_off, ":margin", Dimension::ANGLE, std::f64::consts::FRAC_PI_2)?;
                requirements.sun =
                    margin_rad.map(|margin_rad| SunKeepOut { margin_deg: Some(margin_rad.to_degrees()) });
            }
            "look-ahead" => {
                let [value] = self.rest else { return Err(self.wrong("expected one duration".to_string())) };
                requirements.look_ahead_s = self.figure(value, Dimension::TIME, 86_400.0)?;
            }
            other => {
                let known = "airspace, terrain, landing-distance, energy, mission-end, turbulence, wind, icing, link, heat, sun, look-ahead";
                return Err(self.wrong(format!("unknown requirement `{other}`; known are {known}")));
            }
        }
        Ok(())
    }

    fn landing(&self, is_off: bool) -> MissionResult<Option<LandingReach>> {
        if is_off {
            return Ok(None);
        }
        if self.settings.landing_distance_m_max.is_some() {
            return Err(self.wrong("the application states `:landing-distance` too".to_string()));
        }
        match self.rest {
            [Value::Symbol(key), value] if key.is(":within") => {
                let distance_m_max = self.figure(value, Dimension::LENGTH, LENGTH_M_MAX)?;
                Ok(Some(LandingReach::Disc { distance_m_max }))
            }
            [Value::Symbol(key)] if key.is(":gliding") => Ok(Some(LandingReach::Gliding { pattern_m: PATTERN_M })),
            [Value::Symbol(key), Value::Symbol(pattern), value] if key.is(":gliding") && pattern.is(":pattern") => {
                let pattern_m = self.figure(value, Dimension::LENGTH, LENGTH_M_MAX)?;
                Ok(Some(LandingReach::Gliding { pattern_m }))
            }
            _ => {
                Err(self
                    .wrong("expected `:within DISTANCE`, or `:gliding` with an optional `:pattern HEIGHT`".to_string()))
            }
        }
    }

    /// Returns the only key and its figure.
    fn one(&self, is_off: bool, key: &str, unit: Dimension, most: f64) -> MissionResult<Option<f64>> {
        if is_off {
            return Ok(None);
        }
        match self.rest {
            [Value::Symbol(found), value] if found.is(key) => self.figure(value, unit, most).map(Some),
            _ => Err(self.wrong(format!("expected `{key}` with a figure, or `:off`"))),
        }
    }

    fn pairs(&self) -> MissionResult<Vec<(&str, &Value)>> {
        let mut pairs: Vec<(&str, &Value)> = Vec::new();
        for pair in self.rest.chunks(2) {
            let [Value::Symbol(key), value] = pair else {
                return Err(self.wrong("expected keys, each with a figure".to_string()));
            };
            if pairs.iter().any(|(known, _)| *known == key.folded()) {
                return Err(self.wrong(format!("`{key}` is given twice")));
            }
            pairs.push((key.folded(), value));
        }
        Ok(pairs)
    }

    fn unknown(&self, key: &str, known: &str) -> MissionError {
        self.wrong(format!("unknown key `{key}`; known are {known}"))
    }

    /// Returns a positive figure in SI units; bare numbers are SI.
    fn figure(&self, value: &Value, unit: Dimension, most: f64) -> MissionResult<f64> {
        match value.as_number() {
            Some((si, found)) if (found == unit || found == Dimension::NONE) && si > 0.0 && si <= most => Ok(si),
            _ => {
                let (word, example) = word(unit);
                Err(self.wrong(format!(
                    "`{value}` is not {word} greater than zero and at most {most:.4} (SI); write one such as {example}"
                )))
            }
        }
    }
}

/// Returns the word for a quantity with its article, and an example.
fn word(unit: Dimension) -> (&'static str, &'static str) {
    match unit {
        Dimension::LENGTH => ("a length", "300m"),
        Dimension::TIME => ("a duration", "5min"),
        Dimension::SPEED => ("a speed", "10m/s"),
        Dimension::ANGLE => ("an angle", "10deg"),
        Dimension::TEMPERATURE => ("a temperature", "320K"),
        _ => ("a number", "0.5"),
    }
}

fn wrong(settings: &Stated<'_>, form: &Value, why: String) -> MissionError {
    MissionError::setting(format!("in :requirements, `{form}` cannot be read"))
        .at(settings.place)
        .because(why)
        .help(format!("write {USAGE}"))
}
