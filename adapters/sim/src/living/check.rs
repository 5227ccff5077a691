//! Checks of a world file against the vehicle and the radios to which it refers.

use super::{CloudField, DownlinkSpec, FaultKind, FaultSpec, LivingWorld, PerimeterSpec, StormCell, WORLD_FORMAT};
use crate::config::WorldConfig;
use crate::names::unknown_name;
use crate::packet::{VARIABLES, is_number};

/// Maximum number of stated failures.
const FAULTS_MAX: usize = 1_000;
/// Rates above one per second are taken for mistakes.
const RATE_PER_H_MAX: f64 = 3_600.0;
/// Greatest values that are not taken for mistakes: speed of weather over ground and deviation of the wind, m/s; turbulence, m^(2/3)/s, as
/// in wind files; loss of energy, kg/h or W.
const WEATHER_MPS_MAX: f64 = 100.0;
const WIND_SIGMA_MPS_MAX: f64 = 50.0;
const EDR_MAX: f64 = 1.0;
const LEAK_MAX: f64 = 1e6;
/// Least time between two outlines of a fire.
const EVERY_H_MIN: f64 = 0.1;

impl LivingWorld {
    /// Checks every member of the file.
    ///
    /// # Errors
    /// An error message with the field and a valid value.
    pub(crate) fn check(&self, config: &WorldConfig) -> Result<(), String> {
        if self.format != WORLD_FORMAT {
            return Err(format!("`format` is \"{}\"; this version reads \"{WORLD_FORMAT}\"", self.format));
        }
        if self.faults.len() > FAULTS_MAX {
            return Err(format!("`faults` has {} entries; at most {FAULTS_MAX} can be stated", self.faults.len()));
        }
        for (index, fault) in self.faults.iter().enumerate() {
            fault.check(config).map_err(|reason| format!("faults[{index}]: {reason}"))?;
        }
        if let Some(ignitions) = &self.ignitions {
            share("ignitions.detection", ignitions.detection)?;
            share("ignitions.false_alarm", ignitions.false_alarm)?;
            not_negative("ignitions.seen_from_m2", ignitions.seen_from_m2)?;
            if config.sites.is_empty() {
                return Err("`ignitions` needs targets of kind \"structure\", which have rates; this mission has none"
                    .to_owned());
            }
        }
        if let Some(perimeters) = &self.perimeters {
            perimeters.check(config).map_err(|reason| format!("perimeters.{reason}"))?;
        }
        for (index, cloud) in self.clouds.iter().enumerate() {
            cloud.check().map_err(|reason| format!("clouds[{index}].{reason}"))?;
        }
        for (index, storm) in self.storms.iter().enumerate() {
            storm.check().map_err(|reason| format!("storms[{index}].{reason}"))?;
        }
        if let Some(error) = &self.wind_error {
            within("wind_error.sigma_mps", error.sigma_mps, (0.0, WIND_SIGMA_MPS_MAX))?;
            not_negative("wind_error.sigma_share", error.sigma_share)?;
            not_negative("wind_error.edr_log_sigma", error.edr_log_sigma)?;
            positive("wind_error.correlation_h", error.correlation_h)?;
            positive("wind_error.correlation_km", error.correlation_km)?;
        }
        self.downlink.as_ref().map_or(Ok(()), |downlink| downlink.check(config))
    }
}

impl PerimeterSpec {
    fn check(&self, config: &WorldConfig) -> Result<(), String> {
        // With shorter intervals, reports would flood the planner, and outlines would grow by less than the accuracy of their corners.
        if !(self.every_h.is_finite() && self.every_h >= EVERY_H_MIN) {
            return Err(format!("every_h is {}; it must be at least {EVERY_H_MIN}", self.every_h));
        }
        not_negative("from_h", self.from_h)?;
        share("rate_share", self.rate_share)?;
        if config.burning.is_empty() {
            return Err("targets: this mission has no fire with an outline or a size".to_owned());
        }
        let known = || config.burning.iter().map(|fire| fire.name.as_str());
        match self.targets.iter().find(|name| !known().any(|known| known.eq_ignore_ascii_case(name))) {
            Some(name) => Err(unknown_name("targets", name, known())),
            None => Ok(()),
        }
    }
}

impl FaultSpec {
    fn check(&self, config: &WorldConfig) -> Result<(), String> {
        let word = self.fault.word();
        match (self.at_s, self.rate_per_h) {
            (Some(at_s), None) => not_negative("at_s", at_s)?,
            (None, Some(rate)) if rate > 0.0 && rate <= RATE_PER_H_MAX => {}
            (None, Some(rate)) => {
                return Err(format!("`rate_per_h` is {rate}; it must be above 0 and at most {RATE_PER_H_MAX}"));
            }
            (Some(_), Some(_)) => return Err("it states both `at_s` and `rate_per_h`; state one of them".to_owned()),
            (None, None) => return Err("it states neither `at_s` nor `rate_per_h`; state one of them".to_owned()),
        }
        if let Some(for_s) = self.for_s {
            positive("for_s", for_s)?;
        }
        if self.by.is_some_and(|by| !by.is_finite()) {
            return Err("`by` must be a finite number".to_owned());
        }
        let cameras: Vec<&str> = config.model.cameras.iter().map(|camera| camera.name.as_str()).collect();
        let modems: Vec<&str> = config.modems.iter().map(|modem| modem.name.as_str()).collect();
        let variables: Vec<&str> = VARIABLES.iter().map(|variable| variable.name).collect();
        let with_scanner = cameras.iter().copied().chain(config.model.scanner.as_ref().map(|_| "scanner"));
        let (what, known): (&str, Vec<&str>) = match self.fault {
            FaultKind::Gimbal | FaultKind::Cooling => ("camera", cameras),
            FaultKind::Sensor => ("sensor", with_scanner.collect()),
            FaultKind::Modem => ("modem", modems),
            FaultKind::Freeze | FaultKind::Silence | FaultKind::Bias => ("state variable", variables),
            FaultKind::Engine
            | FaultKind::Leak
            | FaultKind::PayloadPower
            | FaultKind::Navigation
            | FaultKind::Acknowledgements => {
                return self.check_without_object(word);
            }
        };
        let Some(of) = &self.of else {
            return Err(format!("a `{word}` fault needs `of`, the name of a {what}: {}", listed(&known)));
        };
        if !known.iter().any(|name| name.eq_ignore_ascii_case(of)) {
            return Err(unknown_name(what, of, known.iter().copied()));
        }
        match (self.fault, self.by) {
            (FaultKind::Bias, None) => {
                Err("a `bias` fault needs `by`, the amount that is added, in SI units".to_owned())
            }
            // A word, a place or a truth value has no number to which the amount is added.
            (FaultKind::Bias, Some(_)) if !is_number(of) => {
                let numbers: Vec<&str> =
                    VARIABLES.iter().map(|each| each.name).filter(|name| is_number(name)).collect();
                Err(format!(
                    "`{of}` is not a number, so that `bias` has no effect on it; numbers are {}",
                    listed(&numbers)
                ))
            }
            (FaultKind::Bias, Some(_)) | (_, None) => Ok(()),
            (_, Some(_)) => Err(format!("`by` has no effect in a `{word}` fault; leave it out")),
        }
    }

    fn check_without_object(&self, word: &str) -> Result<(), String> {
        if let Some(of) = &self.of {
            return Err(format!("`of` \"{of}\" has no effect in a `{word}` fault; leave it out"));
        }
        match (self.fault, self.by) {
            (FaultKind::Leak, Some(by)) => positive("by", by).and_then(|()| within("by", by, (0.0, LEAK_MAX))),
            (FaultKind::Leak, None) => Err("a `leak` fault needs `by`, in kg/h of fuel or W of charge".to_owned()),
            (FaultKind::Navigation, _) | (_, None) => Ok(()),
            (_, Some(_)) => Err(format!("`by` has no effect in a `{word}` fault; leave it out")),
        }
    }
}

impl CloudField {
    fn check(&self) -> Result<(), String> {
        place(self.latitude_deg, self.longitude_deg)?;
        positive("radius_m", self.radius_m)?;
        share("cover", self.cover)?;
        motion(self.east_mps, self.north_mps)?;
        if !(self.base_m.is_finite() && self.top_m > self.base_m) {
            return Err(format!("base_m is {} and top_m {}; the top must be above the base", self.base_m, self.top_m));
        }
        span(self.from_h, self.until_h)
    }
}

impl StormCell {
    fn check(&self) -> Result<(), String> {
        place(self.latitude_deg, self.longitude_deg)?;
        positive("radius_m", self.radius_m)?;
        within("edr", self.edr, (0.0, EDR_MAX))?;
        motion(self.east_mps, self.north_mps)?;
        span(self.from_h, self.until_h)
    }
}

impl DownlinkSpec {
    fn check(&self, config: &WorldConfig) -> Result<(), String> {
        if !config.modems.iter().any(|modem| modem.name.eq_ignore_ascii_case(&self.over)) {
            let known: Vec<&str> = config.modems.iter().map(|modem| modem.name.as_str()).collect();
            return Err(format!("downlink.over: modem `{}` not found; `:modems` has {}", self.over, listed(&known)));
        }
        positive("downlink.rate_mbit_s", self.rate_mbit_s)?;
        positive("downlink.picture_mbit", self.picture_mbit)?;
        not_negative("downlink.processing_s", self.processing_s)?;
        if self.store_mbit < self.picture_mbit {
            return Err(format!(
                "downlink.store_mbit is {}, less than one picture of {} Mbit",
                self.store_mbit, self.picture_mbit
            ));
        }
        Ok(())
    }
}

fn listed(names: &[&str]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

fn share(field: &str, number: f64) -> Result<(), String> {
    if (0.0..=1.0).contains(&number) { Ok(()) } else { Err(format!("{field} is {number}; it must be from 0 to 1")) }
}

fn within(field: &str, number: f64, (least, most): (f64, f64)) -> Result<(), String> {
    if (least..=most).contains(&number) {
        return Ok(());
    }
    Err(format!("{field} is {number}; it must be from {least} to {most}"))
}

/// Checks the speed at which weather moves.
fn motion(east_mps: f64, north_mps: f64) -> Result<(), String> {
    within("east_mps", east_mps, (-WEATHER_MPS_MAX, WEATHER_MPS_MAX))?;
    within("north_mps", north_mps, (-WEATHER_MPS_MAX, WEATHER_MPS_MAX))
}

fn positive(field: &str, number: f64) -> Result<(), String> {
    let right = number.is_finite() && number > 0.0;
    if right { Ok(()) } else { Err(format!("{field} is {number}; it must be a number above 0")) }
}

fn not_negative(field: &str, number: f64) -> Result<(), String> {
    let right = number.is_finite() && number >= 0.0;
    if right { Ok(()) } else { Err(format!("{field} is {number}; it must not be negative")) }
}

fn place(latitude_deg: f64, longitude_deg: f64) -> Result<(), String> {
    if latitude_deg.abs() <= 89.9 && longitude_deg.abs() <= 180.0 {
        return Ok(());
    }
    Err(format!("latitude_deg, longitude_deg: {latitude_deg}, {longitude_deg} is not a place"))
}

fn span(from_h: f64, until_h: Option<f64>) -> Result<(), String> {
    not_negative("from_h", from_h)?;
    match until_h {
        Some(until_h) if until_h.is_nan() || until_h <= from_h => {
            Err(format!("until_h is {until_h}; it must be after from_h, {from_h}"))
        }
        _ => Ok(()),
    }
}
