//! Diffraction over terrain: the worst single knife edge of the profile over an earth of 4/3 radius (ITU-R P.526).

use super::antenna::Antenna;
use crate::geodesy::{EARTH_RADIUS_M_MEAN, Position, RAD_PER_DEG};
use libm::{asin, atan2, cos, log10, sin, sqrt};

/// Radius of the earth on which rays through a standard atmosphere are straight, over the true radius (ITU-R P.834).
const EFFECTIVE_RADIUS: f64 = 4.0 / 3.0;
/// Kilometres of horizon for each square root of a metre of height: `sqrt(2 (4/3) R)`, rounded as usual.
const HORIZON_KM_PER_SQRT_M: f64 = 4.12;
/// Below this parameter an edge does not reach into the beam (ITU-R P.526).
const NU_CLEAR: f64 = -0.78;
/// Spacing of the samples of a profile, m, until there are [`PROFILE_SAMPLES_MAX`].
const PROFILE_STEP_M: f64 = 100.0;
/// Maximum number of samples of a profile; longer paths are sampled more sparsely.
pub const PROFILE_SAMPLES_MAX: usize = 256;

/// Returns the distance at which two antennas see each other over a smooth earth of 4/3 radius, m: `4.12 (sqrt h1 + sqrt h2)` km.
pub fn radio_horizon_m(height_m: f64, other_height_m: f64) -> f64 {
    1e3 * HORIZON_KM_PER_SQRT_M * (sqrt(height_m.max(0.0)) + sqrt(other_height_m.max(0.0)))
}

/// Returns the diffraction parameter of an edge `height_m` above the straight line (negative: below), at `before_m` and `behind_m` from its
/// ends: `h sqrt((2 / lambda) (1/d1 + 1/d2))`.
pub fn knife_edge_nu(height_m: f64, before_m: f64, behind_m: f64, wavelength_m: f64) -> f64 {
    height_m * sqrt(2.0 / wavelength_m * (1.0 / before_m + 1.0 / behind_m))
}

/// Returns the loss at a knife edge, dB: `J = 6.9 + 20 log10(sqrt((nu - 0.1)^2 + 1) + nu - 0.1)` above nu = -0.78, otherwise 0. Never
/// negative.
pub fn knife_edge_loss_db(nu: f64) -> f64 {
    if nu <= NU_CLEAR {
        return 0.0;
    }
    let above = nu - 0.1;
    (6.9 + 20.0 * log10(sqrt(above * above + 1.0) + above)).max(0.0)
}

/// Returns the clearance at which an obstacle hardly weakens the link, m: 0.6 of the radius of the first Fresnel zone.
pub fn fresnel_clearance_m(before_m: f64, behind_m: f64, wavelength_m: f64) -> f64 {
    0.6 * sqrt(wavelength_m * before_m * behind_m / (before_m + behind_m))
}

/// Returns the loss of the worst knife edge of the ground between two antennas that are `ground_m` apart over ground, dB.
pub fn diffraction_loss_db(
    from: &Antenna,
    to: &Antenna,
    ground_m: f64,
    wavelength_m: f64,
    elevation_m_at: impl Fn(Position) -> f64,
) -> f64 {
    let spans = ((ground_m / PROFILE_STEP_M).ceil() as usize).clamp(1, PROFILE_SAMPLES_MAX + 1);
    let arc = Arc::new(from.position, to.position);
    let mut nu_max = f64::NEG_INFINITY;
    for sample in 1..spans {
        let share = sample as f64 / spans as f64;
        let (before_m, behind_m) = (share * ground_m, (1.0 - share) * ground_m);
        let line_m = from.altitude_m + share * (to.altitude_m - from.altitude_m);
        let bulge_m = before_m * behind_m / (2.0 * EFFECTIVE_RADIUS * EARTH_RADIUS_M_MEAN);
        let above_m = elevation_m_at(arc.at(share)) + bulge_m - line_m;
        nu_max = nu_max.max(knife_edge_nu(above_m, before_m, behind_m, wavelength_m));
    }
    knife_edge_loss_db(nu_max)
}

/// The great circle between two positions, for samples: within metres of the geodesic over the paths of radios.
struct Arc {
    from: [f64; 3],
    to: [f64; 3],
    angle: f64,
}

impl Arc {
    fn new(from: Position, to: Position) -> Arc {
        let (from, to) = (unit(from), unit(to));
        let chord = from.iter().zip(to).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        Arc { from, to, angle: 2.0 * asin((0.5 * sqrt(chord)).min(1.0)) }
    }

    fn at(&self, share: f64) -> Position {
        let whole = sin(self.angle);
        let (of_from, of_to) = if whole < 1e-9 {
            (1.0 - share, share)
        } else {
            (sin((1.0 - share) * self.angle) / whole, sin(share * self.angle) / whole)
        };
        let [x, y, z] = [0, 1, 2].map(|axis: usize| {
            let of = |vector: &[f64; 3]| vector.get(axis).copied().unwrap_or_default();
            of_from * of(&self.from) + of_to * of(&self.to)
        });
        Position { latitude_deg: atan2(z, sqrt(x * x + y * y)) / RAD_PER_DEG, longitude_deg: atan2(y, x) / RAD_PER_DEG }
    }
}

fn unit(position: Position) -> [f64; 3] {
    let (latitude, longitude) = (position.latitude_deg * RAD_PER_DEG, position.longitude_deg * RAD_PER_DEG);
    [cos(latitude) * cos(longitude), cos(latitude) * sin(longitude), sin(latitude)]
}
