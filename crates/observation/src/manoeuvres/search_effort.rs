//! Probability of detection by search effort (Koopman; IAMSAR volume II): the coverage factor is the area swept, counting
//! repetitions, over the area searched.

/// Returns the coverage factor `C = W L / A` of a sweep width, a length of path and an area.
pub fn coverage_factor(sweep_width_m: f64, length_m: f64, area_m2: f64) -> f64 {
    sweep_width_m * length_m / area_m2
}

/// Returns the probability of detection by a random search: `1 - exp(-C)`.
pub fn random_probability(coverage_factor: f64) -> f64 {
    1.0 - libm::exp(-coverage_factor.max(0.0))
}

/// Returns the probability of detection by parallel sweeps with the inverse cube law: `erf(sqrt(pi) C / 2)`.
pub fn parallel_probability(coverage_factor: f64) -> f64 {
    libm::erf(0.5 * libm::sqrt(std::f64::consts::PI) * coverage_factor.max(0.0))
}
