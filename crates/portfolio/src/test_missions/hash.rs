//! Hashes of missions, which detect changes of the generator.

use crate::cell::Cell;
use apex_model::problem::{CostFunction, SurveillanceProblem};
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// Number of bytes of a cell's hash that are written down.
const BYTES: usize = 16;

impl Cell {
    /// Returns the hash over its missions from number 0 to before `missions`, to the last bit of every number.
    pub fn hash(&self, missions: u64) -> String {
        let all = (0..missions).fold(Sha256::new(), |all, number| all.chain_update(hash(&self.mission(number))));
        hexadecimal(all.finalize().iter().take(BYTES))
    }
}

/// Returns the hash of every number of a mission.
fn hash(problem: &SurveillanceProblem) -> String {
    let mut hash = Sha256::new();
    let mut number = |number: f64| hash.update(number.to_bits().to_le_bytes());
    number(problem.horizon_s);
    for target in &problem.targets {
        // Missions of cells have no other costs.
        if let CostFunction::Saturating { maximum, rate_per_s } = target.cost {
            number(maximum);
            number(rate_per_s);
        }
        [target.dwell_s, target.rate.at(0.0), target.initial_age_s].into_iter().for_each(&mut number);
        [target.position.latitude_deg, target.position.longitude_deg].into_iter().for_each(&mut number);
    }
    problem.travel.from_start_s.iter().chain(problem.travel.between_s.iter().flatten()).copied().for_each(number);
    hexadecimal(hash.finalize().iter())
}

fn hexadecimal<'a>(bytes: impl Iterator<Item = &'a u8>) -> String {
    bytes.fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
