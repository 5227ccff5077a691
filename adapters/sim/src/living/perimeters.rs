//! Growing perimeters: the fires of the mission continue to burn with the wind, and their outlines are reported at intervals.

use super::{BurningTarget, PerimeterSpec};
use apex_geo::fire::{FireSpread, grown};
use apex_geo::plane::{Plane, Point};
use apex_model::problem::Position;
use apex_model::time::Time;
use apex_model::value::Value;
use libm::hypot;

const HOUR_S: f64 = 3_600.0;
/// Corners are reported to about a metre.
const PER_DEGREE: f64 = 1e5;

/// The outlines now.
#[derive(Clone, Debug)]
pub(crate) struct Perimeters {
    spec: PerimeterSpec,
    fires: Vec<BurningTarget>,
    grown_s: f64,
    next_s: f64,
}

impl Perimeters {
    /// Returns the outlines of the fires that grow according to the world file.
    pub(crate) fn new(spec: PerimeterSpec, fires: &[BurningTarget]) -> Perimeters {
        let is_named = |fire: &&BurningTarget| {
            spec.targets.is_empty() || spec.targets.iter().any(|name| name.eq_ignore_ascii_case(&fire.name))
        };
        let fires = fires.iter().filter(is_named).cloned().collect();
        let (grown_s, next_s) = (spec.from_h * HOUR_S, (spec.from_h + spec.every_h) * HOUR_S);
        Perimeters { spec, fires, grown_s, next_s }
    }

    /// Returns the instant of the next report; `None` if there is no further one.
    pub(crate) fn next_s(&self) -> Option<f64> {
        let is_over = self.spec.until_h.is_some_and(|until_h| self.next_s > until_h * HOUR_S);
        (!self.fires.is_empty() && !is_over).then_some(self.next_s)
    }

    /// Returns the messages `(new-perimeter TARGET ((LATITUDE LONGITUDE) ..))` that are due; `wind` returns the wind at a place and time,
    /// east and north, m/s.
    pub(crate) fn reports(&mut self, now: Time, wind: impl Fn(Position, f64) -> (f64, f64)) -> Vec<Value> {
        let mut reports = Vec::new();
        while let Some(at_s) = self.next_s().filter(|at_s| *at_s <= now.seconds()) {
            let age_s = self.spec.rate_share * (at_s - self.grown_s);
            for fire in &mut self.fires {
                fire.burn(wind(fire.middle, 0.5 * (self.grown_s + at_s)), age_s);
                reports.push(fire.report());
            }
            (self.grown_s, self.next_s) = (at_s, at_s + self.spec.every_h * HOUR_S);
        }
        reports
    }
}

impl BurningTarget {
    fn burn(&mut self, (east_mps, north_mps): (f64, f64), age_s: f64) {
        let plane = Plane::new(self.middle);
        let outline: Vec<Point> = self.outline.iter().filter_map(|corner| plane.project(*corner)).collect();
        let wind_mps = hypot(east_mps, north_mps);
        let towards = match wind_mps > 1e-6 {
            true => Point { x: east_mps / wind_mps, y: north_mps / wind_mps },
            false => Point { x: 0.0, y: 1.0 },
        };
        let outline = grown(&outline, Point::default(), &FireSpread::in_wind(wind_mps), towards, age_s);
        self.outline = outline.into_iter().map(|corner| plane.position(corner)).collect();
    }

    fn report(&self) -> Value {
        let digits = |degrees: f64| Value::Real(libm::round(degrees * PER_DEGREE) / PER_DEGREE);
        let corner = |at: &Position| Value::list([digits(at.latitude_deg), digits(at.longitude_deg)]);
        let corners = Value::list(self.outline.iter().map(corner));
        Value::list([Value::symbol("new-perimeter"), Value::symbol(&self.name), corners])
    }
}
