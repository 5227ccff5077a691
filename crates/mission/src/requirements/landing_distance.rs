//! The landing distance: the margin to the reach of landing places, and the time until the route leaves it.

use super::readings::{DISTANCE_M_MAX, Reading, Scene};
use super::response::Response;
use super::statement::LandingReach;
use apex_geo::geodesy::Position;
use apex_model::quantity::Dimension;
use apex_requirements::margin::landing::{Glide, disc_m, glide_m};
use apex_requirements::prediction::RouteSpan;
use apex_requirements::{Concern, Route, first_violation};

/// Speed of the best glide as a share of cruise speed.
const GLIDE_SPEED_SHARE: f64 = 0.65;

impl Scene<'_> {
    /// Returns the reading of the landing distance.
    pub(super) fn landing(&self) -> Option<Reading> {
        let reach = self.requirements().landing?;
        let model = &self.mission.model;
        let margin_m = |position: Position, altitude_m: f64| {
            let (site, (distance_m, track_deg)) = self.way_to_site(position);
            match reach {
                LandingReach::Disc { distance_m_max } => disc_m(distance_m, distance_m_max),
                LandingReach::Gliding { pattern_m } => {
                    let glide = Glide {
                        ratio: model.glide_ratio,
                        airspeed_mps: GLIDE_SPEED_SHARE * model.true_airspeed_m_s_cruise,
                    };
                    let tail_mps = self.ground_speed_mps(track_deg, glide.airspeed_mps) - glide.airspeed_mps;
                    glide_m(glide, altitude_m - site.elevation_m, pattern_m, tail_mps, distance_m)
                }
            }
        };
        let margin = margin_m(self.here, self.flown.altitude_m);
        let span = RouteSpan { from_s: 0.0, until_s: self.requirements().look_ahead_s };
        // A glide reaches less far by the glide ratio, in metres, for each metre of height lost.
        let change_per_s = |route: &Route| match reach {
            LandingReach::Disc { .. } => route.speed_mps_max(),
            LandingReach::Gliding { .. } => route.speed_mps_max() * (1.0 + model.glide_ratio),
        };
        let lost_s = |route: &Route| {
            let lost = first_violation(route, span, change_per_s(route), |state| {
                margin_m(self.plane.position(state.point), state.altitude_m)
            });
            lost.map(|lost| lost.after_s)
        };
        let lost_s = self.routes().filter_map(lost_s).min_by(f64::total_cmp);
        Some(Reading {
            concern: Concern::LandingDistance,
            name: "landing-distance",
            margin: margin.min(DISTANCE_M_MAX * 10.0),
            unit: Dimension::LENGTH,
            after_s: lost_s,
            response_s: self.turn_away_s(),
            what: self.nearest_site(self.here).0.name.to_string(),
            response: Response::TurnAway,
        })
    }
}
