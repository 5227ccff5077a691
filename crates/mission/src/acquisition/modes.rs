//! Modes of a manoeuvre in PDL notation: `:attitude`, `:heading`, `:pace` and `:data` of every form, with the modes of a form that states
//! none.

use super::data_mode::DataMode;
use super::form::{Form, read_path};
use super::sweep_form::{SweptGround, read_sweep};
use crate::downlink::StatedDownlink;
use apex_geo::geodesy::wrap_180;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_observation::manoeuvres::{
    AttitudeMode, Craft, DataHandling, FlightPath, Instrument, Manoeuvre, PayloadUse, SpeedProfile, Sweep,
};
use apex_observation::sensor::CameraSetting;

/// Modes that a form states; `None`: those of the path, the vehicle and the goal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Modes {
    pub(crate) attitude: Option<AttitudeMode>,
    pub(crate) speed: Option<SpeedProfile>,
    pub(crate) data: Option<DataMode>,
}

/// Values of `:pace`.
const PACES: &str =
    "(airspeed SPEED), (ground-speed SPEED), (overlap SHARE), (slow-at-closest SPEED) or (smear PIXELS)";

/// Reads a manoeuvre: its flight path, and the modes that its form states.
///
/// # Errors
/// The missing, unknown or wrongly typed argument.
pub(crate) fn manoeuvre_of_form(value: &Value, ground: &SweptGround<'_>) -> Result<(FlightPath, Modes), String> {
    let mut form = Form::read(value, "the manoeuvre")?;
    let path = match form.name() {
        Sweep::NAME => FlightPath::Sweep(read_sweep(&mut form, ground)?),
        _ => read_path(&mut form)?,
    };
    let modes = Modes::read(&mut form)?;
    form.finish()?;
    Ok((path, modes))
}

impl Modes {
    /// Reads the modes of a form.
    ///
    /// # Errors
    /// A mode that does not exist, a heading without a fixed attitude, or a figure that is out of its range.
    pub(crate) fn read(form: &mut Form<'_>) -> Result<Modes, String> {
        let heading_deg = form.optional_angle_deg("heading")?;
        let name = form.name().to_string();
        let attitude = match (form.word("attitude").as_deref(), heading_deg) {
            (None | Some("fixed"), Some(heading_deg)) => Some(AttitudeMode::Fixed { heading_deg }),
            (Some("fixed"), None) => {
                return Err(format!("`:attitude` of `{name}` is fixed; add its direction, such as `:heading 90deg`"));
            }
            (None, None) => None,
            (Some(word @ ("coordinated" | "pointing")), Some(_)) => {
                return Err(format!("`{name}` has `:heading` and is {word}; only `:attitude fixed` has a heading"));
            }
            (Some("coordinated"), None) => Some(AttitudeMode::Coordinated),
            (Some("pointing"), None) => Some(AttitudeMode::Pointing),
            (Some(word), _) => {
                return Err(format!("`:attitude` of `{name}` is {word}; write coordinated, fixed or pointing"));
            }
        };
        let speed = form.value("pace").map(|value| pace(&name, value)).transpose()?;
        let data = form.value("data").map(|value| DataMode::read(value, &name)).transpose()?;
        Ok(Modes { attitude, speed, data })
    }

    /// Returns the direction of the nose: as stated, otherwise towards the target for paths around it or next to it, and at right angles to a
    /// strafe.
    pub(crate) fn attitude_of(&self, path: &FlightPath, can_hover: bool) -> AttitudeMode {
        let is_aimed = matches!(
            path,
            FlightPath::StandOff(_) | FlightPath::Arc(_) | FlightPath::Orbit(_) | FlightPath::VantagePoint(_)
        );
        let usual = match path {
            FlightPath::Strafe(strafe) => AttitudeMode::Fixed { heading_deg: strafe.track_deg + 90.0 },
            _ if is_aimed && can_hover => AttitudeMode::Pointing,
            _ => AttitudeMode::Coordinated,
        };
        self.attitude.unwrap_or(usual)
    }

    /// Returns the handling of the data: as stated, otherwise stored.
    ///
    /// # Errors
    /// Data that are sent need a link.
    pub(crate) fn data_over(&self, link: Option<&StatedDownlink>) -> Result<DataHandling, String> {
        self.data.map_or(Ok(DataHandling::Store), |data| data.over(link))
    }

    /// Returns the speed profile: as stated, otherwise the speed of the goal, which is the airspeed of a fixed wing and the ground speed of a
    /// vehicle that hovers; without one, the speed of the sharpest pictures.
    pub(crate) fn speed_of(&self, speed_mps: Option<f64>, can_hover: bool) -> SpeedProfile {
        let usual = match speed_mps {
            Some(speed_mps) if can_hover => SpeedProfile::GroundSpeed(speed_mps),
            Some(speed_mps) => SpeedProfile::Airspeed(speed_mps),
            None => SpeedProfile::Smear(1.0),
        };
        self.speed.unwrap_or(usual)
    }
}

/// Returns the sensor with the interval at which the goal takes pictures, if the camera could take them faster: the speed of an overlap
/// depends on it.
pub(super) fn at_interval(instrument: Instrument, payload: &PayloadUse) -> Instrument {
    match (instrument, payload) {
        (Instrument::Camera(camera), PayloadUse::StillsInterval(interval_s)) => {
            let interval_s_min = camera.interval_s_min.max(*interval_s);
            Instrument::Camera(CameraSetting { interval_s_min, ..camera })
        }
        (instrument, _) => instrument,
    }
}

/// Rejects a direction of the nose in which a camera that does not pan cannot see what the path observes.
///
/// # Errors
/// The attitude that works.
pub(crate) fn check_sight(manoeuvre: &Manoeuvre, craft: &Craft, instrument: &Instrument) -> Result<(), String> {
    let Instrument::Camera(camera) = instrument else { return Ok(()) };
    if !craft.can_hover || camera.mount.pan_deg.1 > camera.mount.pan_deg.0 {
        return Ok(());
    }
    let (is_seen, works) = match (&manoeuvre.path, manoeuvre.attitude) {
        (FlightPath::Strafe(strafe), AttitudeMode::Fixed { heading_deg }) => {
            let off_deg = wrap_180(heading_deg - strafe.track_deg - 90.0).abs();
            (off_deg < 1.0, "a heading at right angles to the track, to the right, works")
        }
        (FlightPath::Strafe(_), _) => (false, "leave `:attitude` out"),
        (FlightPath::StandOff(_) | FlightPath::Orbit(_) | FlightPath::VantagePoint(_), attitude) => {
            (attitude == AttitudeMode::Pointing, "`:attitude pointing` works")
        }
        _ => (true, ""),
    };
    match is_seen {
        true => Ok(()),
        false => Err(format!(
            "`{}`: `{}` does not pan, and does not see the target with the nose in this direction; {works}",
            manoeuvre.path.name(),
            camera.name
        )),
    }
}

/// Reads a speed profile.
fn pace(name: &str, value: &Value) -> Result<SpeedProfile, String> {
    let wrong = || format!("`:pace` of `{name}` is {value}; write {PACES}");
    let Some([Value::Symbol(head), figure]) = value.as_list() else { return Err(wrong()) };
    let number = |dimension: Dimension| match figure.as_number() {
        Some((number, found)) if (found == dimension || found == Dimension::NONE) && number.is_finite() => Some(number),
        _ => None,
    };
    let speed = || number(Dimension::SPEED).filter(|speed_mps| *speed_mps > 0.0).ok_or_else(wrong);
    match head.folded() {
        "airspeed" => speed().map(SpeedProfile::Airspeed),
        "ground-speed" => speed().map(SpeedProfile::GroundSpeed),
        "slow-at-closest" => speed().map(SpeedProfile::SlowAtClosest),
        "overlap" => {
            let share = number(Dimension::NONE).filter(|share| (0.0..1.0).contains(share));
            share.map(SpeedProfile::Overlap).ok_or_else(wrong)
        }
        "smear" => number(Dimension::NONE).filter(|pixels| *pixels > 0.0).map(SpeedProfile::Smear).ok_or_else(wrong),
        _ => Err(wrong()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic, reason = "a failed test should stop")]

    use super::super::vehicle::instrument_of;
    use super::{SweptGround, at_interval, manoeuvre_of_form};
    use crate::vehicle::VehicleModel;
    use apex_model::value::Value;
    use apex_observation::manoeuvres::{AttitudeMode, Instrument, PayloadUse, SpeedProfile};

    fn over(more: &[(&str, Value)]) -> Value {
        let fields =
            [("track", 30.0), ("height", 60.0), ("length", 200.0)].map(|(key, value)| (key, Value::Real(value)));
        let fields = fields.iter().chain(more);
        let fields = fields.flat_map(|(key, value)| [Value::symbol(&format!(":{key}")), value.clone()]);
        Value::list(std::iter::once(Value::symbol("straight-over")).chain(fields))
    }

    fn pace(head: &str, figure: f64) -> Value {
        Value::list([Value::symbol(head), Value::Real(figure)])
    }

    #[test]
    fn a_sweep_of_a_point_needs_two_lengths() {
        let instrument = instrument_of(&VehicleModel::named("quadrotor").unwrap(), None).unwrap();
        let ground = SweptGround { target: "field", corners: &[], instrument: &instrument };
        let why = |fields: &[(&str, f64)]| {
            let fields = fields.iter().flat_map(|(key, value)| [Value::symbol(key), Value::Real(*value)]);
            let form = Value::list(std::iter::once(Value::symbol("sweep")).chain(fields));
            manoeuvre_of_form(&form, &ground).map(|_| ()).err().unwrap_or_default()
        };
        let point = why(&[(":height", 30.0)]);
        assert!(point.starts_with("`field` is a point; add `:length` and `:width` to `sweep`"), "{point}");
        let half = why(&[(":height", 30.0), (":length", 80.0)]);
        assert!(half.starts_with("`:length` and `:width` of `sweep` are both positive"), "{half}");
        assert_eq!(why(&[(":height", 30.0), (":length", 80.0), (":width", 40.0)]), "");
    }

    #[test]
    fn the_speed_of_an_overlap_is_that_of_the_stated_interval() {
        let usual = instrument_of(&VehicleModel::named("quadrotor").unwrap(), None).unwrap();
        let speed_mps = |payload: PayloadUse| at_interval(usual.clone(), &payload).overlap_speed_mps(60.0, 0.8);
        let Instrument::Camera(camera) = &usual else { panic!("the quadrotor has a camera") };
        let picture_m = camera.footprint_m(60.0).1;
        assert!((speed_mps(PayloadUse::StillsInterval(2.0)) - 0.2 * picture_m / 2.0).abs() < 1e-9);
        let fastest_mps = 0.2 * picture_m / camera.interval_s_min;
        assert!((speed_mps(PayloadUse::StillsEvery(5.0)) - fastest_mps).abs() < 1e-9);
        assert!((speed_mps(PayloadUse::StillsInterval(0.01)) - fastest_mps).abs() < 1e-9);
    }

    #[test]
    fn every_form_has_an_attitude_and_a_pace() {
        let instrument = instrument_of(&VehicleModel::named("quadrotor").unwrap(), None).unwrap();
        let ground = SweptGround { target: "field", corners: &[], instrument: &instrument };
        let read = |more: &[(&str, Value)]| manoeuvre_of_form(&over(more), &ground).map(|(_, modes)| modes);
        let of = |more: &[(&str, Value)]| read(more).map(|modes| (modes.attitude, modes.speed));
        assert_eq!(of(&[]), Ok((None, None)));
        assert_eq!(
            of(&[("attitude", Value::symbol("fixed")), ("heading", Value::Real(90.0))]),
            Ok((Some(AttitudeMode::Fixed { heading_deg: 90.0 }), None))
        );
        assert_eq!(of(&[("attitude", Value::symbol("pointing"))]), Ok((Some(AttitudeMode::Pointing), None)));
        for (head, figure, speed) in [
            ("airspeed", 9.0, SpeedProfile::Airspeed(9.0)),
            ("ground-speed", 9.0, SpeedProfile::GroundSpeed(9.0)),
            ("slow-at-closest", 9.0, SpeedProfile::SlowAtClosest(9.0)),
            ("overlap", 0.6, SpeedProfile::Overlap(0.6)),
            ("smear", 0.5, SpeedProfile::Smear(0.5)),
        ] {
            assert_eq!(of(&[("pace", pace(head, figure))]), Ok((None, Some(speed))));
        }
        let why = |more: &[(&str, Value)]| read(more).unwrap_err();
        assert!(why(&[("attitude", Value::symbol("fixed"))]).contains("add its direction, such as `:heading 90deg`"));
        assert!(why(&[("attitude", Value::symbol("level"))]).contains("write coordinated, fixed or pointing"));
        let both = [("attitude", Value::symbol("pointing")), ("heading", Value::Real(90.0))];
        assert!(why(&both).contains("only `:attitude fixed` has a heading"));
        for wrong in [pace("fast", 3.0), pace("overlap", 1.5), pace("airspeed", -1.0), Value::Real(3.0)] {
            assert!(why(&[("pace", wrong)]).contains("write (airspeed SPEED), (ground-speed SPEED), (overlap SHARE)"));
        }
    }
}
