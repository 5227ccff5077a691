//! The wind that is assumed in flight: the forecast, corrected by what was measured.

use apex_geo::wind::Wind;
use apex_model::problem::{FOREVER_S, WindField, WindLayer};
use serde::{Deserialize, Serialize};

/// Time over which measurements are averaged: gusts last for seconds, and a wrong forecast for hours.
const AVERAGED_S: f64 = 120.0;
/// Time for which plans assume that the forecast stays wrong in the same way.
const LASTING_S: f64 = 6.0 * 3600.0;
/// Highest altitude of a layer of air.
const HIGHEST_M: f64 = 1e5;

/// Difference of the measured wind from the forecast, averaged over the last minutes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct WindError {
    east_mps: f64,
    north_mps: f64,
    /// Instant of the last measurement.
    at_s: Option<f64>,
}

impl WindError {
    /// Takes a measurement at `now_s` where `forecast` was expected.
    pub(crate) fn take(&mut self, measured: Wind, forecast: Wind, now_s: f64) {
        let share = self.at_s.map_or(1.0, |at_s| -libm::expm1(-(now_s - at_s).max(0.0) / AVERAGED_S));
        self.east_mps += share * (measured.east_mps - forecast.east_mps - self.east_mps);
        self.north_mps += share * (measured.north_mps - forecast.north_mps - self.north_mps);
        self.at_s = Some(now_s);
    }

    /// Returns a forecast wind as corrected.
    pub(crate) fn corrected(&self, forecast: Wind) -> Wind {
        Wind { east_mps: forecast.east_mps + self.east_mps, north_mps: forecast.north_mps + self.north_mps, ..forecast }
    }

    /// Returns the forecast for a plan made at `now_s`: corrected for six hours, then unchanged. `None` if nothing was measured.
    pub(crate) fn field(&self, forecast: &WindField, now_s: f64) -> Option<WindField> {
        self.at_s?;
        let until_s = now_s + LASTING_S;
        let still = WindLayer {
            area: None,
            altitude_m_min: -HIGHEST_M,
            altitude_m_max: HIGHEST_M,
            from_s: 0.0,
            until_s: FOREVER_S,
            wind_east_mps: 0.0,
            wind_north_mps: 0.0,
            edr: 0.0,
        };
        // Air that the forecast leaves out is still. Where layers are blended, another one would change those between which it lies.
        let rest = (!forecast.blend || forecast.layers.is_empty()).then_some(&still);
        let mut layers = Vec::new();
        for layer in rest.into_iter().chain(&forecast.layers) {
            if layer.from_s < until_s {
                layers.push(WindLayer {
                    until_s: layer.until_s.min(until_s),
                    wind_east_mps: layer.wind_east_mps + self.east_mps,
                    wind_north_mps: layer.wind_north_mps + self.north_mps,
                    ..*layer
                });
            }
            if layer.until_s > until_s {
                layers.push(WindLayer { from_s: layer.from_s.max(until_s), ..*layer });
            }
        }
        Some(WindField { layers, blend: forecast.blend })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_geo::geodesy::Position;
    use apex_geo::wind;

    fn blowing(east_mps: f64, north_mps: f64) -> Wind {
        Wind { east_mps, north_mps, edr: 0.1 }
    }

    #[test]
    fn a_gust_counts_little_and_a_wrong_forecast_counts_after_minutes() {
        let mut error = WindError::default();
        error.take(blowing(12.0, 0.0), blowing(10.0, 0.0), 0.0);
        assert_eq!(error.corrected(blowing(10.0, 1.0)), blowing(12.0, 1.0), "the first measurement counts");
        error.take(blowing(40.0, 0.0), blowing(10.0, 0.0), 5.0);
        assert!((error.east_mps - 3.1).abs() < 0.1, "{error:?}");
        for second in 1..=600 {
            error.take(blowing(30.0, -20.0), blowing(10.0, 0.0), 5.0 + 3.0 * f64::from(second));
        }
        assert!((error.east_mps - 20.0).abs() < 1.0 && (error.north_mps + 20.0).abs() < 1.1, "{error:?}");
    }

    #[test]
    fn plans_assume_the_error_for_six_hours() {
        let layer = |low_m, high_m, from_h: f64, until_h: f64, east_mps| WindLayer {
            area: None,
            altitude_m_min: low_m,
            altitude_m_max: high_m,
            from_s: from_h * 3600.0,
            until_s: until_h * 3600.0,
            wind_east_mps: east_mps,
            wind_north_mps: 0.0,
            edr: 0.1,
        };
        let forecast = WindField {
            layers: vec![layer(0.0, 9_000.0, 0.0, 4.0, 10.0), layer(0.0, 9_000.0, 4.0, 24.0, 15.0)],
            blend: false,
        };
        assert_eq!(WindError::default().field(&forecast, 3_600.0), None, "nothing was measured");
        let mut error = WindError::default();
        error.take(blowing(15.0, 5.0), blowing(10.0, 0.0), 3_600.0);
        let field = error.field(&forecast, 3_600.0).unwrap();
        let at = |altitude_m, hours: f64| {
            let wind = wind::at(&field, Position::new(40.0, -120.0), altitude_m, hours * 3600.0);
            (wind.east_mps, wind.north_mps)
        };
        assert_eq!((at(5e3, 2.0), at(5e3, 5.0)), ((15.0, 5.0), (20.0, 5.0)));
        assert_eq!((at(5e3, 6.9), at(5e3, 7.1), at(5e3, 20.0)), ((20.0, 5.0), (15.0, 0.0), (15.0, 0.0)));
        assert_eq!((at(1e4, 2.0), at(1e4, 8.0)), ((5.0, 5.0), (0.0, 0.0)), "air without a forecast counts as still");
    }
}
