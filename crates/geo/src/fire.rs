//! Growth of a fire as an ellipse in wind.
//!
//! Head rate: a tenth of the open wind at 10 m (Cruz and Alexander 2019, forests and shrubs, dry and windy; error up to 50 %). Shape:
//! length to breadth by the wind at mid-flame height (Finney 1998, FARSITE); the wind there is taken as 0.4 of the open wind. The fire
//! starts at a focus: it spreads ahead by the head rate and back by the head rate over `head_to_back`.

use libm::{exp, sqrt};

/// Share of the open wind at 10 m that blows at mid-flame height.
pub const MID_FLAME_SHARE: f64 = 0.4;
/// Head rate for each m/s of open wind.
pub const HEAD_SHARE: f64 = 0.10;
/// Head rate in still air: a fire spreads without wind, too.
pub const HEAD_MPS_MIN: f64 = 0.01;

/// Rates of an elliptical fire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FireSpread {
    /// Advance of the head with the wind.
    pub head_mps: f64,
    /// Advance of the back against the wind.
    pub back_mps: f64,
    /// Growth of half the breadth.
    pub half_breadth_mps: f64,
    /// Length over breadth.
    pub length_to_breadth: f64,
}

impl FireSpread {
    /// Returns the spread in an open wind of `wind_mps` at 10 m.
    pub fn in_wind(wind_mps: f64) -> FireSpread {
        let head_mps = (HEAD_SHARE * wind_mps).max(HEAD_MPS_MIN);
        let length_to_breadth = length_to_breadth(MID_FLAME_SHARE * wind_mps);
        let root = sqrt((length_to_breadth * length_to_breadth - 1.0).max(0.0));
        let head_to_back = (length_to_breadth + root) / (length_to_breadth - root);
        let back_mps = head_mps / head_to_back;
        let half_length_mps = 0.5 * (head_mps + back_mps);
        FireSpread { head_mps, back_mps, half_breadth_mps: half_length_mps / length_to_breadth, length_to_breadth }
    }

    /// Returns the length and breadth, m, `age_s` after the fire broke out at a point.
    pub fn size_m(&self, age_s: f64) -> (f64, f64) {
        let age_s = age_s.max(0.0);
        ((self.head_mps + self.back_mps) * age_s, 2.0 * self.half_breadth_mps * age_s)
    }

    /// Returns area, m2, `age_s` after the fire broke out at a point.
    pub fn area_m2(&self, age_s: f64) -> f64 {
        let (length_m, breadth_m) = self.size_m(age_s);
        0.25 * std::f64::consts::PI * length_m * breadth_m
    }
}

/// Returns the length over breadth at a mid-flame wind, m/s; at least 1.
fn length_to_breadth(mid_flame_mps: f64) -> f64 {
    let ratio = 0.936 * exp(0.2566 * mid_flame_mps) + 0.461 * exp(-0.1548 * mid_flame_mps) - 0.397;
    ratio.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, wanted: f64, within: f64) {
        assert!((value - wanted).abs() <= within, "{value} for {wanted}");
    }

    /// The ratios that FARSITE's formula gives for mid-flame winds of 1, 2, 4 and 8 m/s.
    #[test]
    fn length_to_breadth_follows_the_wind() {
        for (wind_mps, wanted) in [(1.0, 1.208), (2.0, 1.505), (4.0, 2.464), (8.0, 7.028)] {
            near(length_to_breadth(wind_mps), wanted, 0.001);
        }
        assert_eq!(length_to_breadth(0.0), 1.0);
    }

    /// In an open wind of 5 m/s: head 0.5, back 0.072, half breadth 0.190 m/s; after an hour 2,060 m by 1,369 m, 2.22 km2.
    #[test]
    fn an_hour_in_five_metres_a_second() {
        let spread = FireSpread::in_wind(5.0);
        near(spread.head_mps, 0.5, 1e-12);
        near(spread.back_mps, 0.072, 0.0005);
        near(spread.half_breadth_mps, 0.190, 0.0005);
        let (length_m, breadth_m) = spread.size_m(3_600.0);
        near(length_m, 2_060.0, 5.0);
        near(breadth_m, 1_369.0, 5.0);
        near(spread.area_m2(3_600.0) / 1e6, 2.22, 0.01);
        near(0.5 * (spread.head_mps - spread.back_mps) * 3_600.0, 770.0, 2.0);
    }
}
