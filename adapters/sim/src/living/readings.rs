//! Readings of subsystems and of the weather radar, as reported by a vehicle in a dynamic world.

use super::FaultKind;
use crate::geodesic::bearing;
use crate::packet::rounded;
use crate::world::SimulatedWorld;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_geo::sun;
use apex_model::event::{EventKind, StateVariable};
use apex_model::quantity::{Dimension, Quantity, UNITS};
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use libm::{acos, cos, sin};

/// Voltage of the payload bus, V.
const PAYLOAD_V: f64 = 28.0;
/// Position errors, m, from which the navigation is degraded.
const DEGRADED_M: f64 = 50.0;
/// Cells farther than this are not on the radar.
const RADAR_M: f64 = 300_000.0;

impl SimulatedWorld {
    /// Adds the readings of subsystems and of the weather radar to a packet.
    pub(crate) fn report_subsystems(&self, inputs: &mut Vec<Input>) {
        let Some(living) = &self.living else { return };
        let (now, now_s) = (self.now, self.now.seconds());
        let mut say = |attribute: &str, object: &str, value: Value| {
            let variable = StateVariable::new(Symbol::new(attribute), Value::symbol(object));
            inputs.push(Input::new(now, EventKind::Measurement(variable, value)));
        };
        let truth = |holds: bool| if holds { Value::symbol("t") } else { Value::nil() };
        let power = living.faults.find(FaultKind::PayloadPower, "", now).is_none();
        say("payload-voltage", &self.vehicle, Value::Real(if power { PAYLOAD_V } else { 0.0 }));
        let navigation = living.faults.find(FaultKind::Navigation, "", now);
        let state = match navigation.map(|span| span.by) {
            None => "good",
            Some(None) => "lost",
            Some(Some(_)) if self.navigation.length_m() < DEGRADED_M => "good",
            Some(Some(_)) => "degraded",
        };
        say("navigation-state", &self.vehicle, Value::symbol(state));
        for (camera, detector_k) in self.cameras.iter().zip(&living.detectors_k) {
            let name = &camera.model.name;
            say("detector-temperature", name, measured(*detector_k, "K", 100.0));
            if camera.aim.is_some() {
                say("gimbal-error", name, measured(camera.error_rad, "deg", 100.0));
            }
            if camera.is_ready() || !power {
                say("frame-rate", name, Value::Real(if camera.broken || !power { 0.0 } else { 1.0 }));
                if let Some(angle_rad) = self.sun_angle_rad(camera.tilt_rad, camera.pan_rad) {
                    say("sun-angle", name, measured(angle_rad, "deg", 100.0));
                }
            }
        }
        if !living.spec.clouds.is_empty() {
            let (position, altitude_m) = (self.position(), self.state.altitude_m);
            let air = crate::atmosphere::Air::at(altitude_m);
            say("in-cloud", &self.vehicle, truth(living.is_in_cloud(position, altitude_m, now_s)));
            say("icing", &self.vehicle, truth(living.is_icing(position, altitude_m, air.temperature_k, now_s)));
            say("ice-exposure", &self.vehicle, measured(living.ice_s, "s", 10.0));
        }
        let cells = living.spec.storms.iter().filter_map(|storm| {
            let distance_m = storm.distance_m(self.position(), now_s)?;
            Some((distance_m, bearing(self.position(), storm.middle(now_s)).0, storm.radius_m))
        });
        let nearest = cells.filter(|cell| cell.0 < RADAR_M).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance_m, azimuth_rad, radius_m)) = nearest {
            say("storm-radius", &self.vehicle, measured(radius_m, "m", 1.0));
            say("storm-distance", &self.vehicle, measured(distance_m, "m", 1.0));
            say("storm-bearing", &self.vehicle, measured(azimuth_rad, "deg", 10.0));
        }
        if let Some(downlink) = &living.downlink {
            let share = downlink.used_mbit() / downlink.spec.store_mbit;
            say("store-used", &self.vehicle, Value::Real(rounded(share, 1e4)));
        }
    }

    /// Returns the angle between the sight line of a mount and the sun; half a turn if the sun is below the horizon, `None` without civil
    /// time.
    fn sun_angle_rad(&self, tilt_rad: f64, pan_rad: f64) -> Option<f64> {
        let unix_s = self.living.as_ref()?.epoch_unix_s? + self.now.seconds();
        let elevation_rad = sun::solar_elevation_deg(self.state.position, unix_s) * RAD_PER_DEG;
        let azimuth_rad = sun::solar_azimuth_deg(self.state.position, unix_s) * RAD_PER_DEG;
        let look_rad = self.state.heading_rad + pan_rad;
        let cosine =
            sin(elevation_rad) * sin(tilt_rad) + cos(elevation_rad) * cos(tilt_rad) * cos(azimuth_rad - look_rad);
        Some(if elevation_rad > 0.0 { acos(cosine.clamp(-1.0, 1.0)) } else { std::f64::consts::PI })
    }
}

/// Returns a number in SI units as a quantity in `unit`, rounded to a multiple of one part in `parts` of that unit.
fn measured(si: f64, unit: &str, parts: f64) -> Value {
    let found = UNITS.iter().enumerate().find(|(_, known)| known.name == unit);
    let Some((index, known)) = found else { return Value::Real(si) };
    let si = rounded(si / known.factor, parts) * known.factor;
    let dimension: Dimension = known.dimension;
    Value::Quantity(Quantity { si, dimension, unit: u8::try_from(index).ok() })
}
