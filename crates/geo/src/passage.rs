//! Times of a route flown again and again through wind that changes at known instants.
//!
//! Between two changes the time of every sub-step is computed once; only a flight across a change adds sub-steps up.
//! Equal to [`LegProfile::time_s`] leg by leg, but for rounding. Bound: O(sub-steps) per question, mostly O(log changes).

use crate::wind::LegProfile;
use apex_model::problem::{WindField, WindLayer};

/// A wind field at one altitude, cut at the instants at which it changes.
#[derive(Clone, Debug, PartialEq)]
pub struct ChangingWind {
    altitude_m: f64,
    true_airspeed_mps: f64,
    /// When the wind changes, in order.
    changes_s: Vec<f64>,
    /// Between changes: a time in the span, and what blows then.
    spans: Vec<(f64, WindField)>,
    speed_mps_max: f64,
}

impl ChangingWind {
    /// The wind of `field` at `altitude_m` from `from_s` to `until_s`, for flying at `true_airspeed_mps`.
    pub fn new(field: &WindField, altitude_m: f64, true_airspeed_mps: f64, from_s: f64, until_s: f64) -> ChangingWind {
        let heights = |layer: &&WindLayer| {
            field.blend || (layer.altitude_m_min <= altitude_m && altitude_m < layer.altitude_m_max)
        };
        let layers: Vec<&WindLayer> = field.layers.iter().filter(heights).collect();
        let ends = layers.iter().flat_map(|layer| [layer.from_s, layer.until_s]);
        let mut changes_s: Vec<f64> = ends.filter(|time_s| *time_s > from_s && *time_s < until_s).collect();
        changes_s.sort_by(f64::total_cmp);
        changes_s.dedup();
        let blows = |time_s: f64| {
            let now = layers.iter().filter(|layer| layer.from_s <= time_s && time_s < layer.until_s);
            (time_s, WindField { layers: now.map(|layer| **layer).collect(), blend: field.blend })
        };
        let spans = [from_s].into_iter().chain(changes_s.iter().copied()).map(blows).collect();
        let speeds = layers.iter().map(|layer| libm::hypot(layer.wind_east_mps, layer.wind_north_mps));
        let speed_mps_max = speeds.fold(0.0, f64::max);
        ChangingWind { altitude_m, true_airspeed_mps, changes_s, spans, speed_mps_max }
    }

    /// No ground speed is higher than this.
    pub fn ground_speed_mps_max(&self) -> f64 {
        self.true_airspeed_mps + self.speed_mps_max
    }

    /// The span in which `time_s` lies.
    fn span_at(&self, time_s: f64) -> usize {
        self.changes_s.partition_point(|change_s| *change_s <= time_s)
    }
}

/// A route of legs with the times known so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Passage {
    legs: Vec<LegProfile>,
    /// For each span of the wind, once it is known.
    spans: Vec<Option<Span>>,
}

#[derive(Clone, Debug, PartialEq)]
struct Span {
    /// Time for each sub-step; infinite where it cannot be flown.
    steps_s: Vec<f64>,
    total_s: f64,
}

impl Passage {
    /// A route of `legs`.
    pub fn new(legs: Vec<LegProfile>) -> Passage {
        Passage { legs, spans: Vec::new() }
    }

    /// Number of sub-steps.
    pub fn steps(&self) -> usize {
        self.legs.iter().map(LegProfile::steps).sum()
    }

    /// Time to fly the route, leaving at `depart_s`; none where some part cannot be flown.
    pub fn time_s(&mut self, wind: &ChangingWind, depart_s: f64) -> Option<f64> {
        let mut span = wind.span_at(depart_s);
        let total_s = self.span(wind, span)?.total_s;
        let until_s = wind.changes_s.get(span).copied().unwrap_or(f64::INFINITY);
        if depart_s + total_s <= until_s {
            return total_s.is_finite().then_some(total_s);
        }
        let halves_s: Vec<f64> = self
            .legs
            .iter()
            .flat_map(|leg| std::iter::repeat_n(0.5 * leg.step_m() / wind.true_airspeed_mps, leg.steps()))
            .collect();
        let mut elapsed_s = 0.0;
        for (step, half_s) in halves_s.into_iter().enumerate() {
            while wind.changes_s.get(span).is_some_and(|change_s| depart_s + elapsed_s + half_s >= *change_s) {
                span += 1;
            }
            elapsed_s += self.span(wind, span)?.steps_s.get(step)?;
            if !f64::is_finite(elapsed_s) {
                return None;
            }
        }
        Some(elapsed_s)
    }

    fn span(&mut self, wind: &ChangingWind, span: usize) -> Option<&Span> {
        if self.spans.len() <= span {
            self.spans.resize(wind.spans.len(), None);
        }
        let slot = self.spans.get_mut(span)?;
        if slot.is_none() {
            let (time_s, field) = wind.spans.get(span)?;
            let legs = self.legs.iter();
            let steps_s: Vec<f64> = legs
                .flat_map(|leg| leg.step_times_s(wind.altitude_m, wind.true_airspeed_mps, field, *time_s))
                .collect();
            let total_s = steps_s.iter().sum();
            *slot = Some(Span { steps_s, total_s });
        }
        slot.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::{Area, Position};
    use proptest::prelude::*;

    fn layer(from_s: f64, until_s: f64, east: f64, north: f64, area: Option<Area>) -> WindLayer {
        WindLayer {
            area,
            altitude_m_min: 0.0,
            altitude_m_max: 9000.0,
            from_s,
            until_s,
            wind_east_mps: east,
            wind_north_mps: north,
            turbulence: 0.0,
        }
    }

    proptest! {
        #[test]
        fn a_passage_takes_as_long_as_its_legs(
            winds in prop::collection::vec((0.0..20_000.0f64, 500.0..20_000.0f64, -60.0..60.0f64, -60.0..60.0f64, any::<bool>()), 0..6),
            blend in any::<bool>(), departs in prop::collection::vec(0.0..30_000.0f64, 1..6),
            to in (34.0..44.0f64, -122.0..-110.0f64),
        ) {
            let west = Area { south_deg: 30.0, north_deg: 50.0, west_deg: -125.0, east_deg: -116.0 };
            let layers = winds.iter().map(|(from, lasts, east, north, part)| {
                layer(*from, from + lasts, *east, *north, part.then_some(west))
            });
            let field = WindField { layers: layers.collect(), blend };
            let places = [Position::new(35.0, -118.0), Position::new(38.0, -119.0), Position::new(to.0, to.1)];
            let legs: Vec<LegProfile> =
                places.windows(2).map(|pair| LegProfile::new(pair[0], pair[1]).unwrap()).collect();
            let wind = ChangingWind::new(&field, 7000.0, 70.0, 0.0, 100_000.0);
            let mut passage = Passage::new(legs.clone());
            for depart_s in departs {
                let slow = legs.iter().try_fold(0.0, |elapsed_s, leg| {
                    Some(elapsed_s + leg.time_s(7000.0, 70.0, &field, depart_s + elapsed_s)?)
                });
                match (passage.time_s(&wind, depart_s), slow) {
                    (Some(quick), Some(slow)) => {
                        prop_assert!((quick - slow).abs() < 1e-6 * slow, "{quick} {slow}");
                        let length_m: f64 = legs.iter().map(LegProfile::length_m).sum();
                        prop_assert!(quick >= length_m / wind.ground_speed_mps_max() * 0.999_999);
                    }
                    (quick, slow) => prop_assert_eq!(quick, slow),
                }
            }
        }
    }
}
