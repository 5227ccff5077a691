//! Generator of missions of a cell.

use crate::cell::{Cell, Space, Spread};
use apex_model::problem::{CostFunction, EventRate, Position, SurveillanceProblem, SurveillanceTarget, TravelTimes};
use rand_chacha::ChaCha20Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use sha2::{Digest, Sha256};

/// Version of the generator: part of every seed, and of every table that was measured with it.
pub const GENERATOR_VERSION: u32 = 1;
/// Speed of the vehicle.
pub(super) const SPEED_MPS: f64 = 20.0;
/// Length of one observation.
pub(super) const DWELL_S: f64 = 10.0;
/// Length of a mission.
pub(super) const HORIZON_S: f64 = 3600.0;
/// Rate at which the cost of ignorance gathers where the spread is fixed.
const RATE_PER_S: f64 = 1.0 / 600.0;
/// Least distance between targets, as a share of the side.
const SEPARATION: f64 = 0.01;
/// Standard deviation of a place within one of two clusters, and the distance of the clusters east and west of the centre.
const TWO_CLUSTERS: (f64, f64) = (0.05, 0.38);
/// Standard deviation of a place in a single cluster.
const GLOBULAR: f64 = 0.08;
/// Maximum number of draws of one place; after this number the separation is halved, so that crowded maps can be drawn too.
const DRAWS_MAX: usize = 1_000;
/// Centre of the map, at which every test mission starts; for display.
pub const CENTRE: Position = Position { latitude_deg: 37.4, longitude_deg: -122.1 };

/// The random numbers of one mission.
struct Chance(ChaCha20Rng);

impl Chance {
    /// Returns a real number in 0..1.
    fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns a standard normal number, by the polar form of Box and Muller without its second number.
    fn normal(&mut self) -> f64 {
        loop {
            let (x, y) = (self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            let square = x * x + y * y;
            if square > 0.0 && square < 1.0 {
                return x * libm::sqrt(-2.0 * libm::log(square) / square);
            }
        }
    }

    fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }
}

impl Cell {
    /// Returns the seed of its mission `number`.
    pub fn seed(&self, number: u64) -> [u8; 32] {
        Sha256::digest(format!("apex test mission {GENERATOR_VERSION} {self} {number}")).into()
    }

    /// Returns its mission `number`: targets `T1`, `T2`, .., from a start in the centre of the map, fresh, without a return.
    pub fn mission(&self, number: u64) -> SurveillanceProblem {
        let mut chance = Chance(ChaCha20Rng::from_seed(self.seed(number)));
        let places = self.places(&mut chance);
        let costs = factors(self.cost, self.count, &mut chance);
        let rates = factors(self.rate, self.count, &mut chance);
        let time_s = |from: (f64, f64), to: (f64, f64)| libm::hypot(to.0 - from.0, to.1 - from.1) / SPEED_MPS;
        let from_start_s: Vec<f64> = places.iter().map(|place| time_s((0.0, 0.0), *place)).collect();
        let targets = places.iter().zip(costs.iter().zip(&rates)).enumerate().map(|(index, (place, (cost, rate)))| {
            SurveillanceTarget {
                name: format!("T{}", index + 1),
                position: position(*place),
                dwell_s: DWELL_S,
                rate: EventRate::constant(1.0),
                cost: CostFunction::Saturating { maximum: *cost, rate_per_s: rate * RATE_PER_S },
                initial_age_s: 0.0,
            }
        });
        SurveillanceProblem {
            targets: targets.collect(),
            travel: TravelTimes {
                to_base_s: from_start_s.clone(),
                from_start_s,
                between_s: places.iter().map(|from| places.iter().map(|to| time_s(*from, *to)).collect()).collect(),
                later: Vec::new(),
            },
            horizon_s: HORIZON_S,
            return_to_base: false,
            endurance_s: None,
        }
    }

    /// Returns the places in metres east and north of the centre.
    fn places(&self, chance: &mut Chance) -> Vec<(f64, f64)> {
        let side_m = self.scale.side_m();
        let mut places: Vec<(f64, f64)> = Vec::with_capacity(self.count);
        let (mut separation_m, mut draws) = (SEPARATION * side_m, 0);
        while places.len() < self.count {
            let (east, north) = self.place(places.len(), chance);
            let place = (east * side_m, north * side_m);
            draws += 1;
            if draws > DRAWS_MAX {
                (separation_m, draws) = (0.5 * separation_m, 0);
            }
            let apart = |other: &(f64, f64)| libm::hypot(other.0 - place.0, other.1 - place.1) >= separation_m;
            if east.abs() <= 0.5 && north.abs() <= 0.5 && places.iter().all(apart) {
                places.push(place);
                draws = 0;
            }
        }
        places
    }

    /// Returns a place of the target with this index, as shares of the side; may lie outside.
    fn place(&self, index: usize, chance: &mut Chance) -> (f64, f64) {
        match self.space {
            Space::TwoClusters => {
                let (deviation, distance) = TWO_CLUSTERS;
                let centre = if index.is_multiple_of(2) { -distance } else { distance };
                (centre + deviation * chance.normal(), deviation * chance.normal())
            }
            Space::Globular => (GLOBULAR * chance.normal(), GLOBULAR * chance.normal()),
            Space::Uniform => (chance.between(-0.5, 0.5), chance.between(-0.5, 0.5)),
        }
    }
}

/// Returns factors of a quantity over the targets, in a random order.
fn factors(spread: Spread, count: usize, chance: &mut Chance) -> Vec<f64> {
    let mut factors: Vec<f64> = (0..count)
        .map(|index| match spread {
            Spread::Fixed => 1.0,
            Spread::Uniform => chance.between(0.1, 1.9),
            Spread::Clustered if index < count / 2 => 0.2 * chance.between(0.9, 1.1),
            Spread::Clustered => 1.8 * chance.between(0.9, 1.1),
        })
        .collect();
    // Fisher and Yates: small and large values do not depend on positions.
    for last in (1..count).rev() {
        factors.swap(last, chance.below(last + 1));
    }
    factors
}

/// Returns latitude and longitude of a place near the centre of the map; for display and features only, travel is computed in the plane.
fn position((east_m, north_m): (f64, f64)) -> Position {
    let metres_per_deg = 111_195.0;
    let parallel = libm::cos(CENTRE.latitude_deg.to_radians());
    Position {
        latitude_deg: CENTRE.latitude_deg + north_m / metres_per_deg,
        longitude_deg: CENTRE.longitude_deg + east_m / (metres_per_deg * parallel),
    }
}
