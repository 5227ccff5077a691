//! Stages of a flight other than joining: the climb after take-off, paths of points, circles and hovers, the glide to an airfield.

use crate::flight::{ActiveOrder, Order, Progress, Stage};
use crate::gliding::Glide;
use crate::instants;
use crate::path::bearing;
use crate::situation::Situation;
use apex_model::time::Duration;

/// Height of the straight climb after take-off, before the first turn.
const STRAIGHT_CLIMB_M: f64 = 300.0;
/// Distance beyond the field within which the vehicle touches down on level ground.
const OVERRUN_M: f64 = 1_000.0;

impl ActiveOrder {
    /// Returns the altitude of the final approach at the vehicle: on the glide path to the field, and beyond the field that of the ground.
    /// Farther on it sinks below the ground, because a vehicle that lags behind its altitude never reaches ground that falls away.
    pub(crate) fn glide_path_m(&self, here: &Situation) -> f64 {
        let slope = here.model.final_approach_height_m / here.model.final_approach_m;
        let end_m = match self.order {
            Order::Land { field_m, .. } if self.to_go_m > 0.0 => field_m,
            _ => here.ground_m,
        };
        end_m + slope * (self.to_go_m.max(0.0) + (self.to_go_m + OVERRUN_M).min(0.0)) - 2.0
    }

    /// Climbs out, straight ahead and then on a circle.
    pub(crate) fn climb(&mut self, here: &Situation) -> Progress {
        if (here.altitude_m - here.state.altitude_m).abs() <= 10.0_f64.min(0.2 * here.altitude_m.abs().max(5.0)) {
            return self.done(here);
        }
        let high = here.state.altitude_m >= here.ground_m + STRAIGHT_CLIMB_M;
        let turning = matches!(self.stage, Stage::ClimbOut) && high;
        let stated = if let Order::TakeOff { centre, .. } = &self.order { *centre } else { None };
        let centre = stated.unwrap_or(here.state.position);
        let circle = || Stage::Climb(here.circle(centre, here.loiter_radius_m()));
        self.change(turning.then(circle), here)
    }

    /// Follows a path of points to its end.
    pub(crate) fn follow(&mut self, here: &Situation) -> Progress {
        let goes_on = match &mut self.stage {
            Stage::Follow(path) => path.advance(here),
            _ => false,
        };
        if goes_on { Progress::Going } else { self.done(here) }
    }

    /// Circles or hovers; answers when the time on station has passed.
    pub(crate) fn on_station(&mut self, here: &Situation) -> Progress {
        let (there, duration) = match (&self.stage, &self.order) {
            (Stage::Circle(circle), Order::Loiter { duration, .. }) => {
                let error_m = bearing(here.state.position, circle.centre).1 - circle.radius_m;
                (error_m.abs() < 0.15 * circle.radius_m + 5.0, *duration)
            }
            (Stage::Hover(_), Order::Hover { duration, .. }) => {
                (self.to_go_m < 2.0 && here.state.ground_speed() < 0.6 && here.at_altitude(), *duration)
            }
            (stage, Order::FlyTo { to, .. }) => {
                if !here.at_altitude() {
                    return Progress::Going;
                }
                // The circle served to reach the altitude; the commanded place is its centre.
                let circling = matches!(stage, Stage::Circle(_));
                let place = Stage::Direct(to.position);
                return if circling { self.change(Some(place), here) } else { self.done(here) };
            }
            (_, Order::FlyLine { .. } | Order::JoinLine { .. }) => {
                return self.change(here.at_altitude().then_some(Stage::OnLine), here);
            }
            _ => return Progress::Going,
        };
        match (self.until, duration) {
            (Some(until), _) if here.now >= until => self.done(here),
            (None, Some(Duration::ZERO)) if there => self.done(here),
            (None, Some(duration)) if there => {
                self.until = Some(instants::not_before(here.now + duration));
                Progress::StageChanged
            }
            _ => Progress::Going,
        }
    }

    /// Returns the next stage of a landing after an engine failure; `None` if the engine runs, or the glide has begun.
    pub(crate) fn glide(&self, here: &Situation) -> Option<Stage> {
        let Order::Land { at, .. } = &self.order else { return None };
        let is_gliding = here.fixed() && !here.state.engine_running && !here.state.on_ground;
        let begun = matches!(self.stage, Stage::Glide(_) | Stage::RollOut);
        (is_gliding && !begun).then(|| Stage::Glide(Glide::to(at.position)))
    }

    /// Returns true if the flight lands, at any stage.
    pub(crate) fn is_landing(&self) -> bool {
        matches!(self.order, Order::Land { .. })
    }
}
