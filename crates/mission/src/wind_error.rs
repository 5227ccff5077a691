//! The wind that is assumed in flight: the forecast, corrected by what was measured.

use apex_geo::wind::Wind;
use apex_model::problem::{FOREVER_S, WindField, WindLayer};
use serde::{Deserialize, Serialize};

/// Time over which measurements are averaged: gusts last for seconds, and a wrong forecast for hours.
const AVERAGED_S: f64 = 120.0;
/// Time for which plans assume that the forecast stays wrong in the same way, and over which measurements count for the relation of the
/// error to the forecast.
const LASTING_S: f64 = 6.0 * 3600.0;
/// Highest altitude of a layer of air.
const HIGHEST_M: f64 = 1e5;

/// Weight of the assumption that error and forecast are unrelated, m2/s: that of ten minutes of forecasts that differ by 10 m/s.
const UNRELATED_M2_PER_S: f64 = 60_000.0;
/// Weight of the assumption that the forecast is right where it forecasts still air, s. With the weight above, the error of a wind that is
/// measured at one forecast alone is shared between a factor and an offset as if factors had a deviation of 0.33 and offsets of 4 m/s.
const STILL_RIGHT_S: f64 = 400.0;
/// Bounds of the relation: a forecast that is wrong by more is of no use elsewhere.
const RELATION_MIN: f64 = -0.5;
const RELATION_MAX: f64 = 1.5;
/// Difference of the measured error from the one that the relation predicts, with which the past is forgotten within [`FORGOTTEN_S`]; with
/// twice the difference in a quarter of the time. The wind has changed then.
const SURPRISE_MPS: f64 = 4.0;
const FORGOTTEN_S: f64 = 1_200.0;

/// Difference of the measured wind from the forecast: averaged over the last minutes, and its relation to the forecast over the last hours.
///
/// The error elsewhere is that of a line: an offset, and a part that grows with the forecast. Measurements in different winds tell the two
/// apart; without them, most of the error in a strong wind is expected to grow with the forecast. Layers of air differ by their forecasts.
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
    /// Takes an error that lasted for `span_s` where `expected` was forecast, and the surprise about the error over the last minutes.
    fn take(&mut self, expected: [f64; 2], error: [f64; 2], (span_s, surprise): (f64, f64)) {
        let kept = libm::exp(-span_s / LASTING_S - span_s * surprise * surprise / FORGOTTEN_S);
        self.time_s = kept * self.time_s + span_s;
        self.square_m2_per_s = kept * self.square_m2_per_s + span_s * dot(expected, expected);
        self.product_m2_per_s = kept * self.product_m2_per_s + span_s * dot(expected, error);
        let add = |sums: &mut [f64; 2], values: [f64; 2]| {
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum = kept * *sum + span_s * value);
        };
        add(&mut self.expected_m, expected);
        add(&mut self.error_m, error);
    }

    /// Returns the change of the error with the forecast, m/s for each m/s, where `error` is met now and `expected` is forecast.
    fn slope(&self, expected: [f64; 2], error: [f64; 2]) -> f64 {
        let (mut varied, mut together) = (0.0, 0.0);
        if self.time_s > 0.0 {
            varied = (self.square_m2_per_s - dot(self.expected_m, self.expected_m) / self.time_s).max(0.0);
            together = self.product_m2_per_s - dot(self.expected_m, self.error_m) / self.time_s;
        }
        let still = STILL_RIGHT_S * dot(expected, expected);
        let slope = (together + STILL_RIGHT_S * dot(expected, error)) / (varied + still + UNRELATED_M2_PER_S);
        slope.clamp(RELATION_MIN, RELATION_MAX)
    }

    /// Returns the difference of `error` from the mean error so far, which changes with the forecast by `slope`, in units of a difference
    /// that lets the past be forgotten; 0 before the first error.
    fn surprise(&self, slope: f64, expected: [f64; 2], error: [f64; 2]) -> f64 {
        if self.time_s <= 0.0 {
            return 0.0;
        }
        let parts = self.error_m.into_iter().zip(self.expected_m).zip(expected).zip(error);
        let squares = parts.map(|(((error_m, expected_m), expected), error)| {
            let predicted = error_m / self.time_s + slope * (expected - expected_m / self.time_s);
            (error - predicted) * (error - predicted)
        });
        libm::sqrt(squares.sum()) / SURPRISE_MPS
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a.into_iter().zip(b).map(|(a, b)| a * b).sum()
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
        let (mean_expected, mean_error) = self.means();
        let slope = self.relation.slope(mean_expected, mean_error);
        let surprise = self.relation.surprise(slope, mean_expected, mean_error);
        // What happened during a gap of the measurements is not known.
        self.relation.take(expected, error, (span_s.min(AVERAGED_S), surprise));
        self.at_s = Some(now_s);
    }

    /// Returns the correction of forecast winds.
    pub(crate) fn correction(&self) -> Correction {
        let (expected, error) = self.means();
        let slope = self.relation.slope(expected, error);
        let ([expected_east, expected_north], [east, north]) = (expected, error);
        Correction {
            factor: 1.0 + slope,
            east_mps: east - slope * expected_east,
            north_mps: north - slope * expected_north,
        }
    }

    /// Returns the forecast and its error over the last minutes, east and north.
    fn means(&self) -> ([f64; 2], [f64; 2]) {
        ([self.expected_east_mps, self.expected_north_mps], [self.east_mps, self.north_mps])
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
        let corrected = error.correction().of(blowing(10.0, 0.0));
        assert!((corrected.east_mps - 12.0).abs() < 1e-9 && corrected.north_mps == 0.0, "the first measurement counts");
        error.take(blowing(40.0, 0.0), blowing(10.0, 0.0), 5.0);
        assert!((error.east_mps - 3.1).abs() < 0.1, "{error:?}");
        for second in 1..=600 {
            error.take(blowing(30.0, -20.0), blowing(10.0, 0.0), 5.0 + 3.0 * f64::from(second));
        }
        assert!((error.east_mps - 20.0).abs() < 1.0 && (error.north_mps + 20.0).abs() < 1.1, "{error:?}");
    }

    /// Flies for hours at the given forecasts, in winds from the west that are a function of the forecast; returns the corrected wind where
    /// 10 m/s are forecast.
    fn corrected_of_10(winds: &dyn Fn(f64) -> f64, forecasts: [f64; 2]) -> f64 {
        let mut error = WindError::default();
        for second in 0..14_400 {
            let forecast = forecasts[usize::from(second >= 7_200)];
            error.take(blowing(winds(forecast), 0.0), blowing(forecast, 0.0), f64::from(second));
        }
        error.correction().of(blowing(10.0, 0.0)).east_mps
    }

    /// The wind is measured where 5 and where 25 m/s are forecast, and expected where 10 m/s are forecast. A wind of twice the forecast is
    /// expected to be twice the forecast here, too; a wind that differs by 10 m/s everywhere is expected to differ by about as much. Measured at one forecast, most of the error is
    /// expected to grow with it: without that, 35 m/s were expected here.
    #[test]
    fn an_error_grows_with_the_forecast_where_it_was_seen_to() {
        let twice = corrected_of_10(&|forecast| 2.0 * forecast, [5.0, 25.0]);
        assert!((19.0..22.0).contains(&twice), "{twice}");
        let more = corrected_of_10(&|forecast| forecast + 10.0, [5.0, 25.0]);
        assert!((17.5..20.01).contains(&more), "{more}");
        let unknown = corrected_of_10(&|forecast| 2.0 * forecast, [25.0, 25.0]);
        assert!((20.0..24.0).contains(&unknown), "{unknown}");
    }

    /// After hours of a right forecast in various winds, the wind is doubled. Ten minutes at one altitude tell what it is at another, as
    /// hours of measurements did not: the old ones count no longer.
    #[test]
    fn a_wind_that_changes_lets_the_past_be_forgotten() {
        let mut error = WindError::default();
        let mut fly = |from_s: u32, until_s: u32, factor: f64, forecast: &dyn Fn(u32) -> f64| {
            for second in from_s..until_s {
                let forecast = forecast(second);
                error.take(blowing(factor * forecast, 0.0), blowing(forecast, 0.0), f64::from(second));
            }
            error.correction()
        };
        let right = fly(0, 30_000, 1.0, &|second| 8.0 + f64::from(second / 3_000 % 3) * 6.0);
        assert!((right.of(blowing(25.0, 0.0)).east_mps - 25.0).abs() < 0.1, "{right:?}");
        let doubled = fly(30_000, 30_600, 2.0, &|_| 20.0);
        let (low, here) = (doubled.of(blowing(8.0, 0.0)).east_mps, doubled.of(blowing(20.0, 0.0)).east_mps);
        assert!((15.0..20.5).contains(&low) && (39.0..41.0).contains(&here), "{low} {here}: {doubled:?}");
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
            [wind.east_mps, wind.north_mps].map(|mps| (mps * 1e6).round() / 1e6)
        };
        // A fifth of the error grows with the forecast: it is a factor of 1.2 and an offset.
        assert_eq!([at(5e3, 2.0), at(5e3, 5.0)], [[15.0, 5.0], [21.0, 5.0]]);
        assert_eq!([at(5e3, 6.9), at(5e3, 7.1), at(5e3, 20.0)], [[21.0, 5.0], [15.0, 0.0], [15.0, 0.0]]);
        assert_eq!([at(1e4, 2.0), at(1e4, 8.0)], [[3.0, 5.0], [0.0, 0.0]], "air without a forecast counts as still");
    }
}
