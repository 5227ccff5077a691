//! The rules that the figures of a vehicle model obey: each alone, and those that limit each other.

use crate::error::VehicleFileError;
use crate::model::{Airframe, CameraModel, ScannerModel, VehicleModel};

/// Slowest indicated airspeed at which a fixed wing can stay in the air.
const FIXED_WING_M_S_MIN: f64 = 5.0;
/// A range shorter than this is taken for a mistake in units.
const RANGE_M_MIN: f64 = 1_000.0;

/// Values that a figure may have.
#[derive(Clone, Copy, Debug)]
enum Rule {
    /// Greater than zero.
    Positive,
    /// Zero or greater.
    NotNegative,
    /// Any finite number.
    Finite,
    /// From the first to the second, both included.
    Between(f64, f64),
    /// Greater than the first, up to the second included.
    AboveUpTo(f64, f64),
}

impl Rule {
    fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Rule::Positive => value > 0.0,
                Rule::NotNegative => value >= 0.0,
                Rule::Finite => true,
                Rule::Between(low, high) => (low..=high).contains(&value),
                Rule::AboveUpTo(low, high) => value > low && value <= high,
            }
    }

    fn describe(self) -> String {
        match self {
            Rule::Positive => "a number greater than zero".to_owned(),
            Rule::NotNegative => "a number that is not negative".to_owned(),
            Rule::Finite => "a finite number".to_owned(),
            Rule::Between(low, high) => format!("a number from {low} to {high}"),
            Rule::AboveUpTo(low, high) => format!("a number greater than {low} and at most {high}"),
        }
    }
}

/// Checks the figures of one file in order and returns the first error.
struct Checker<'a> {
    file: &'a str,
}

impl Checker<'_> {
    fn each(&self, section: &str, figures: &[(&str, f64, Rule)]) -> Result<(), VehicleFileError> {
        let wrong = figures.iter().find(|(_, value, rule)| !rule.holds(*value));
        let Some((name, value, rule)) = wrong else { return Ok(()) };
        let path = format!("{section}.{name}");
        Err(self.error(path, rule.describe(), value.to_string(), "correct the figure; its unit is part of its name"))
    }

    fn error(&self, path: String, expected: String, found: String, help: &str) -> VehicleFileError {
        VehicleFileError { file: self.file.to_owned(), path, expected, found, help: help.to_owned() }
    }

    /// `value` must be at most `limit`, the figure called `other`.
    fn at_most(&self, path: &str, value: f64, limit: f64, other: &str) -> Result<(), VehicleFileError> {
        if value <= limit {
            return Ok(());
        }
        let expected = format!("at most `{other}`, {limit}");
        Err(self.error(path.to_owned(), expected, value.to_string(), "correct one of the two figures"))
    }
}

impl VehicleModel {
    /// Checks that the figures describe a vehicle that can fly; `file` names the file in errors.
    ///
    /// # Errors
    /// The first figure that breaks a rule, with the rule.
    pub fn validate(&self, file: &str) -> Result<(), VehicleFileError> {
        let check = Checker { file };
        self.check_flight(&check)?;
        self.check_fuel(&check)?;
        self.check_planning(&check)?;
        let report = &self.report;
        let intervals = [
            ("scanning_s", report.scanning_s, Rule::Positive),
            ("manoeuvring_s", report.manoeuvring_s, Rule::Positive),
            ("cruise_s", report.cruise_s, Rule::Positive),
        ];
        check.each("report", &intervals)?;
        self.scanner.as_ref().map_or(Ok(()), |scanner| check_scanner(&check, scanner))?;
        self.cameras.iter().enumerate().try_for_each(|(number, _)| check_camera(&check, &self.cameras, number))
    }

    fn check_flight(&self, check: &Checker<'_>) -> Result<(), VehicleFileError> {
        let fixed_wing = self.airframe == Airframe::FixedWing;
        let if_fixed_wing = |rule: Rule| if fixed_wing { rule } else { Rule::Between(0.0, 0.0) };
        let if_rotorcraft = |rule: Rule| if fixed_wing { Rule::Between(0.0, 0.0) } else { rule };
        let slowest = if_fixed_wing(Rule::Between(FIXED_WING_M_S_MIN, 500.0));
        let figures = [
            ("indicated_airspeed_m_s_min", self.indicated_airspeed_m_s_min, slowest),
            ("true_airspeed_m_s_cruise", self.true_airspeed_m_s_cruise, Rule::Positive),
            ("true_airspeed_m_s_max", self.true_airspeed_m_s_max, Rule::Positive),
            ("acceleration_m_s2_max", self.acceleration_m_s2_max, Rule::Positive),
            ("bank_deg_max", self.bank_deg_max, Rule::AboveUpTo(0.0, 80.0)),
            ("level_roll_deg_max", self.level_roll_deg_max, Rule::AboveUpTo(0.0, 45.0)),
            ("roll_rate_deg_s_max", self.roll_rate_deg_s_max, Rule::Positive),
            ("yaw_rate_deg_s_max", self.yaw_rate_deg_s_max, Rule::Positive),
            ("climb_rate_m_s_max", self.climb_rate_m_s_max, Rule::Positive),
            ("descent_rate_m_s_max", self.descent_rate_m_s_max, Rule::Positive),
            ("ceiling_m", self.ceiling_m, Rule::Positive),
            ("glide_ratio", self.glide_ratio, Rule::AboveUpTo(0.0, 60.0)),
            ("final_approach_m", self.final_approach_m, if_fixed_wing(Rule::Positive)),
            ("final_approach_height_m", self.final_approach_height_m, if_fixed_wing(Rule::Positive)),
            ("braking_share", self.braking_share, if_rotorcraft(Rule::AboveUpTo(0.0, 1.0))),
            ("drag_per_s", self.drag_per_s, if_rotorcraft(Rule::NotNegative)),
        ];
        check.each("flight", &figures)?;
        // A true airspeed is never below the indicated one, so that a slower cruise is a stall at every altitude.
        check.at_most(
            "flight.indicated_airspeed_m_s_min",
            self.indicated_airspeed_m_s_min,
            self.true_airspeed_m_s_cruise,
            "flight.true_airspeed_m_s_cruise",
        )?;
        check.at_most(
            "flight.true_airspeed_m_s_cruise",
            self.true_airspeed_m_s_cruise,
            self.true_airspeed_m_s_max,
            "flight.true_airspeed_m_s_max",
        )
    }

    fn check_fuel(&self, check: &Checker<'_>) -> Result<(), VehicleFileError> {
        let fuel = &self.fuel;
        let [constant, linear, cubic] = fuel.share;
        let figures = [
            ("capacity_kg", fuel.capacity_kg, Rule::Positive),
            ("low_kg", fuel.low_kg, Rule::NotNegative),
            ("flow_kg_h_reference", fuel.flow_kg_h_reference, Rule::Positive),
            ("speed_m_s_reference", fuel.speed_m_s_reference, Rule::Positive),
            ("share[0]", constant, Rule::Finite),
            ("share[1]", linear, Rule::Finite),
            ("share[2]", cubic, Rule::Finite),
            ("altitude_m_reference", fuel.altitude_m_reference, Rule::Positive),
            ("low_altitude_penalty", fuel.low_altitude_penalty, Rule::NotNegative),
            ("climb_penalty", fuel.climb_penalty, Rule::NotNegative),
            ("descent_saving", fuel.descent_saving, Rule::Between(0.0, 1.0)),
        ];
        check.each("fuel", &figures)?;
        check.at_most("fuel.low_kg", fuel.low_kg, fuel.capacity_kg, "fuel.capacity_kg")?;
        for speed in [self.true_airspeed_m_s_cruise, self.true_airspeed_m_s_max] {
            let x = speed / fuel.speed_m_s_reference;
            let flow = constant + linear * x + cubic * x * x * x;
            if flow <= 0.0 {
                let found = format!("{flow} at {speed} m/s");
                let expected = "shares whose flow is greater than zero from cruise to maximum speed".to_owned();
                return Err(check.error("fuel.share".to_owned(), expected, found, "correct the shares of the flow"));
            }
        }
        let range_m = fuel.capacity_kg / fuel.flow_kg_h_reference * 3_600.0 * self.true_airspeed_m_s_cruise;
        if range_m < RANGE_M_MIN {
            let expected = format!("fuel for at least {RANGE_M_MIN} m of cruise");
            let help = "correct `capacity_kg` or `flow_kg_h_reference`; a flow is in kg per hour";
            return Err(check.error("fuel.capacity_kg".to_owned(), expected, format!("fuel for {range_m} m"), help));
        }
        Ok(())
    }

    fn check_planning(&self, check: &Checker<'_>) -> Result<(), VehicleFileError> {
        let turns = [
            ("bank_share", self.turns.bank_share, Rule::AboveUpTo(0.0, 1.0)),
            ("circle_width", self.turns.circle_width, Rule::Between(1.0, 10.0)),
        ];
        check.each("turns", &turns)?;
        let planning = &self.planning;
        let figures = [
            ("cruise_altitude_m", planning.cruise_altitude_m, Rule::Positive),
            ("climb_share", planning.climb_share, Rule::AboveUpTo(0.0, 1.0)),
            ("descent_share", planning.descent_share, Rule::AboveUpTo(0.0, 1.0)),
            ("ceiling_share", planning.ceiling_share, Rule::AboveUpTo(0.0, 1.0)),
            ("reserve_share", planning.reserve_share, Rule::Between(0.0, 0.9)),
            ("visit_height_m", planning.visit_height_m, Rule::Positive),
        ];
        check.each("planning", &figures)?;
        check.at_most("planning.cruise_altitude_m", planning.cruise_altitude_m, self.ceiling_m, "flight.ceiling_m")
    }
}

fn check_scanner(check: &Checker<'_>, scanner: &ScannerModel) -> Result<(), VehicleFileError> {
    let figures = [
        ("field_of_view_deg", scanner.field_of_view_deg, Rule::AboveUpTo(0.0, 178.0)),
        ("pixel_mrad", scanner.pixel_mrad, Rule::Positive),
        ("first_join_s", scanner.first_join_s, Rule::NotNegative),
        ("further_join_s", scanner.further_join_s, Rule::NotNegative),
    ];
    check.each("scanner", &figures)?;
    let heights = &scanner.heights_m;
    let positive = heights.iter().all(|height| Rule::Positive.holds(*height));
    let rising = heights.iter().zip(heights.iter().skip(1)).all(|(low, high)| low < high);
    if heights.is_empty() || !positive || !rising {
        let expected = "one or more heights greater than zero, each greater than the one before".to_owned();
        let found = format!("{heights:?}");
        return Err(check.error("scanner.heights_m".to_owned(), expected, found, "list the heights in rising order"));
    }
    Ok(())
}

fn check_camera(check: &Checker<'_>, cameras: &[CameraModel], number: usize) -> Result<(), VehicleFileError> {
    let Some(camera) = cameras.get(number) else { return Ok(()) };
    let section = format!("cameras[{number}]");
    let figures = [
        ("tilt_deg_min", camera.tilt_deg_min, Rule::Between(-90.0, 90.0)),
        ("tilt_deg_max", camera.tilt_deg_max, Rule::Between(-90.0, 90.0)),
        ("pan_deg_max", camera.pan_deg_max, Rule::Between(0.0, 180.0)),
        ("slew_rate_deg_s", camera.slew_rate_deg_s, Rule::Positive),
        ("field_of_view_deg", camera.field_of_view_deg, Rule::AboveUpTo(0.0, 178.0)),
        ("power_up_s", camera.power_up_s, Rule::NotNegative),
        ("picture_s", camera.picture_s, Rule::NotNegative),
    ];
    check.each(&section, &figures)?;
    if camera.tilt_deg_min >= camera.tilt_deg_max {
        let (expected, found) = (format!("less than `tilt_deg_max`, {}", camera.tilt_deg_max), camera.tilt_deg_min);
        let path = format!("{section}.tilt_deg_min");
        return Err(check.error(path, expected, found.to_string(), "correct one of the two figures"));
    }
    if cameras.iter().take(number).any(|other| other.name == camera.name) {
        let found = format!("`{}` again", camera.name);
        return Err(check.error(format!("{section}.name"), "a name of its own".to_owned(), found, "rename the camera"));
    }
    Ok(())
}
