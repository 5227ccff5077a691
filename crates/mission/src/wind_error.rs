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

/// Weight of the assumption that error and forecast are unrelated, m2/s: that of half an hour of forecasts that differ by 10 m/s.
const UNRELATED_M2_PER_S: f64 = 180_000.0;
/// Bounds of the relation: a forecast that is wrong by more is of no use elsewhere.
const RELATION_MIN: f64 = -0.5;
const RELATION_MAX: f64 = 1.5;

/// Difference of the measured wind from the forecast: averaged over the last minutes, and its relation to the forecast over the last hours.
///
/// An error that was greater where more wind was forecast is expected to be so elsewhere, too. Without such evidence the error is taken to be
/// the same everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct WindError {
    east_mps: f64,
    north_mps: f64,
    /// Forecast at the places of the measurements, averaged in the same way.
    expected_east_mps: f64,
    expected_north_mps: f64,
    /// Instant of the last measurement.
    at_s: Option<f64>,
    relation: Relation,
}

/// Sums over the last hours for the regression of the error on the forecast, both components with one slope.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Relation {
    time_s: f64,
    /// Sums of forecast and error, east and north, m.
    expected_m: [f64; 2],
    error_m: [f64; 2],
    /// Sums of the square of the forecast and of its product with the error, m2/s.
    square_m2_per_s: f64,
    product_m2_per_s: f64,
}

impl Relation {
    /// Takes an error that lasted for `span_s` where `expected` was forecast.
    fn take(&mut self, expected: [f64; 2], error: [f64; 2], span_s: f64) {
        let kept = libm::exp(-span_s / LASTING_S);
        let dot = |a: [f64; 2], b: [f64; 2]| a.into_iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        self.time_s = kept * self.time_s + span_s;
        self.square_m2_per_s = kept * self.square_m2_per_s + span_s * dot(expected, expected);
        self.product_m2_per_s = kept * self.product_m2_per_s + span_s * dot(expected, error);
        let add = |sums: &mut [f64; 2], values: [f64; 2]| {
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum = kept * *sum + span_s * value);
        };
        add(&mut self.expected_m, expected);
        add(&mut self.error_m, error);
    }

    /// Returns the change of the error with the forecast, m/s for each m/s; 0 without evidence.
    fn slope(&self) -> f64 {
        if self.time_s <= 0.0 {
            return 0.0;
        }
        let means = |a: [f64; 2], b: [f64; 2]| a.into_iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / self.time_s;
        let varied = self.square_m2_per_s - means(self.expected_m, self.expected_m);
        let together = self.product_m2_per_s - means(self.expected_m, self.error_m);
        (together / (varied.max(0.0) + UNRELATED_M2_PER_S)).clamp(RELATION_MIN, RELATION_MAX)
    }
}

/// Correction of forecast winds: a factor, and the wind that is added to the product, m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Correction {
    factor: f64,
    east_mps: f64,
    north_mps: f64,
}

impl Correction {
    /// Returns a forecast wind as corrected.
    pub(crate) fn of(&self, forecast: Wind) -> Wind {
        Wind {
            east_mps: self.factor * forecast.east_mps + self.east_mps,
            north_mps: self.factor * forecast.north_mps + self.north_mps,
            ..forecast
        }
    }
}

impl WindError {
    /// Takes a measurement at `now_s` where `forecast` was expected.
    pub(crate) fn take(&mut self, measured: Wind, forecast: Wind, now_s: f64) {
        let span_s = self.at_s.map_or(0.0, |at_s| (now_s - at_s).max(0.0));
        let share = self.at_s.map_or(1.0, |_| -libm::expm1(-span_s / AVERAGED_S));
        let expected = [forecast.east_mps, forecast.north_mps];
        let error = [measured.east_mps - forecast.east_mps, measured.north_mps - forecast.north_mps];
        let means =
            [&mut self.east_mps, &mut self.north_mps, &mut self.expected_east_mps, &mut self.expected_north_mps];
        means
            .into_iter()
            .zip(error.into_iter().chain(expected))
            .for_each(|(mean, value)| *mean += share * (value - *mean));
        // What happened during a gap of the measurements is not known.
        self.relation.take(expected, error, span_s.min(AVERAGED_S));
        self.at_s = Some(now_s);
    }

    /// Returns the correction of forecast winds.
    pub(crate) fn correction(&self) -> Correction {
        let slope = self.relation.slope();
        Correction {
            factor: 1.0 + slope,
            east_mps: self.east_mps - slope * self.expected_east_mps,
            north_mps: self.north_mps - slope * self.expected_north_mps,
        }
    }

    /// Returns the forecast for a plan made at `now_s`: corrected for six hours, then unchanged. `None` if nothing was measured.
    pub(crate) fn field(&self, forecast: &WindField, now_s: f64) -> Option<WindField> {
        self.at_s?;
        let Correction { factor, east_mps, north_mps } = self.correction();
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
                    wind_east_mps: factor * layer.wind_east_mps + east_mps,
                    wind_north_mps: factor * layer.wind_north_mps + north_mps,
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
        assert_eq!(error.correction().of(blowing(10.0, 1.0)), blowing(12.0, 1.0), "the first measurement counts");
        error.take(blowing(40.0, 0.0), blowing(10.0, 0.0), 5.0);
        assert!((error.east_mps - 3.1).abs() < 0.1, "{error:?}");
        for second in 1..=600 {
            error.take(blowing(30.0, -20.0), blowing(10.0, 0.0), 5.0 + 3.0 * f64::from(second));
        }
        assert!((error.east_mps - 20.0).abs() < 1.0 && (error.north_mps + 20.0).abs() < 1.1, "{error:?}");
    }

    /// A wind of twice the forecast, measured where 5 and where 25 m/s are forecast, is expected to be twice the forecast of 10 m/s; measured
    /// at one forecast, and in winds that differ by the same 10 m/s everywhere, the error is the same elsewhere.
    #[test]
    fn an_error_grows_with_the_forecast_where_it_was_seen_to() {
        let fly = |winds: &dyn Fn(f64) -> f64, forecasts: [f64; 2]| {
            let mut error = WindError::default();
            for second in 0..14_400 {
                let forecast = forecasts[usize::from(second >= 7_200)];
                error.take(blowing(winds(forecast), 0.0), blowing(forecast, 0.0), f64::from(second));
            }
            error.correction().of(blowing(10.0, 0.0)).east_mps
        };
        let twice = fly(&|forecast| 2.0 * forecast, [5.0, 25.0]);
        assert!((20.0..23.0).contains(&twice), "{twice}");
        assert!((fly(&|forecast| 2.0 * forecast, [25.0, 25.0]) - 35.0).abs() < 0.01);
        assert!((fly(&|forecast| forecast + 10.0, [5.0, 25.0]) - 20.0).abs() < 0.01);
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
