//! Quantities: a number with its dimension (`pdl.md`, Text).
//!
//! Stored in SI; the unit that the author wrote is kept for printing only. Pure time is [`crate::time::Duration`] and a dimensionless
//! number is a plain real: neither is ever a `Quantity`.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Exponents of the base dimensions. Angle counts as a dimension, so that degrees differ from plain numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Dimension {
    /// Exponent of length (m).
    pub length: i8,
    /// Exponent of mass (kg).
    pub mass: i8,
    /// Exponent of time (s).
    pub time: i8,
    /// Exponent of electric current (A).
    pub current: i8,
    /// Exponent of thermodynamic temperature (K).
    pub temperature: i8,
    /// Exponent of plane angle (rad).
    pub angle: i8,
}

impl Dimension {
    const fn new(length: i8, mass: i8, time: i8, current: i8, temperature: i8, angle: i8) -> Dimension {
        Dimension { length, mass, time, current, temperature, angle }
    }
    /// A pure number.
    pub const NONE: Dimension = Dimension::new(0, 0, 0, 0, 0, 0);
    /// Time (s).
    pub const TIME: Dimension = Dimension::new(0, 0, 1, 0, 0, 0);
    /// Length (m).
    pub const LENGTH: Dimension = Dimension::new(1, 0, 0, 0, 0, 0);
    /// Speed (m/s).
    pub const SPEED: Dimension = Dimension::new(1, 0, -1, 0, 0, 0);
    /// Acceleration (m/s^2).
    pub const ACCELERATION: Dimension = Dimension::new(1, 0, -2, 0, 0, 0);
    /// Mass (kg).
    pub const MASS: Dimension = Dimension::new(0, 1, 0, 0, 0, 0);
    /// Plane angle (rad).
    pub const ANGLE: Dimension = Dimension::new(0, 0, 0, 0, 0, 1);
    /// Frequency (Hz).
    pub const FREQUENCY: Dimension = Dimension::new(0, 0, -1, 0, 0, 0);
    /// Thermodynamic temperature (K).
    pub const TEMPERATURE: Dimension = Dimension::new(0, 0, 0, 0, 1, 0);
    /// Pressure (Pa).
    pub const PRESSURE: Dimension = Dimension::new(-1, 1, -2, 0, 0, 0);
    /// Power (W).
    pub const POWER: Dimension = Dimension::new(2, 1, -3, 0, 0, 0);
    /// Voltage (V).
    pub const VOLTAGE: Dimension = Dimension::new(2, 1, -3, -1, 0, 0);
    /// Current (A).
    pub const CURRENT: Dimension = Dimension::new(0, 0, 0, 1, 0, 0);
    /// Area (m^2).
    pub const AREA: Dimension = Dimension::new(2, 0, 0, 0, 0, 0);

    /// Returns the dimension of a product.
    pub fn times(self, other: Dimension) -> Dimension {
        self.combine(other, i8::saturating_add)
    }

    /// Returns the dimension of a quotient.
    pub fn over(self, other: Dimension) -> Dimension {
        self.combine(other, i8::saturating_sub)
    }

    fn combine(self, other: Dimension, f: fn(i8, i8) -> i8) -> Dimension {
        Dimension::new(
            f(self.length, other.length),
            f(self.mass, other.mass),
            f(self.time, other.time),
            f(self.current, other.current),
            f(self.temperature, other.temperature),
            f(self.angle, other.angle),
        )
    }
}

impl fmt::Display for Dimension {
    /// Writes a word if there is one (`length`, `speed`), otherwise SI base units (`m^2 kg s^-3`).
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = [
            (Dimension::NONE, "a pure number"),
            (Dimension::TIME, "time"),
            (Dimension::LENGTH, "length"),
            (Dimension::SPEED, "speed"),
            (Dimension::ACCELERATION, "acceleration"),
            (Dimension::MASS, "mass"),
            (Dimension::ANGLE, "angle"),
            (Dimension::FREQUENCY, "frequency"),
            (Dimension::TEMPERATURE, "temperature"),
            (Dimension::PRESSURE, "pressure"),
            (Dimension::POWER, "power"),
            (Dimension::VOLTAGE, "voltage"),
            (Dimension::CURRENT, "current"),
            (Dimension::AREA, "area"),
        ];
        if let Some((_, word)) = words.iter().find(|(dimension, _)| dimension == self) {
            return f.write_str(word);
        }
        let parts = [
            ("m", self.length),
            ("kg", self.mass),
            ("s", self.time),
            ("A", self.current),
            ("K", self.temperature),
            ("rad", self.angle),
        ];
        let mut first = true;
        for (name, exponent) in parts.iter().filter(|(_, exponent)| *exponent != 0) {
            if !first {
                f.write_str(" ")?;
            }
            first = false;
            if *exponent == 1 { f.write_str(name)? } else { write!(f, "{name}^{exponent}")? }
        }
        Ok(())
    }
}

/// A unit of measure that PDL text may name.
#[derive(Debug, PartialEq)]
pub struct Unit {
    /// The canonical spelling, used when printing.
    pub name: &'static str,
    /// Other accepted spellings, lower case.
    pub aliases: &'static [&'static str],
    /// Measured dimension.
    pub dimension: Dimension,
    /// SI value of one unit.
    pub factor: f64,
}

const fn unit(name: &'static str, aliases: &'static [&'static str], dimension: Dimension, factor: f64) -> Unit {
    Unit { name, aliases, dimension, factor }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Every unit that PDL knows. `FL` is written before its number (`FL120`).
pub static UNITS: &[Unit] = &[
    unit("ns", &["nanosecond", "nanoseconds"], Dimension::TIME, 1e-9),
    unit("us", &["microsecond", "microseconds"], Dimension::TIME, 1e-6),
    unit("ms", &["millisecond", "milliseconds", "msec", "msecs"], Dimension::TIME, 1e-3),
    unit("s", &["sec", "secs", "second", "seconds"], Dimension::TIME, 1.0),
    unit("min", &["mins", "minute", "minutes"], Dimension::TIME, 60.0),
    unit("h", &["hr", "hrs", "hour", "hours"], Dimension::TIME, 3600.0),
    unit("d", &["day", "days"], Dimension::TIME, 86_400.0),
    unit("w", &["wk", "wks", "week", "weeks"], Dimension::TIME, 604_800.0),
    unit("m", &["meter", "meters", "metre", "metres"], Dimension::LENGTH, 1.0),
    unit("mm", &["millimeter", "millimeters", "millimetre", "millimetres"], Dimension::LENGTH, 1e-3),
    unit("cm", &["centimeter", "centimeters", "centimetre", "centimetres"], Dimension::LENGTH, 1e-2),
    unit("km", &["kilometer", "kilometers", "kilometre", "kilometres"], Dimension::LENGTH, 1000.0),
    unit("ft", &["foot", "feet"], Dimension::LENGTH, 0.3048),
    unit("nm", &["nmi", "nautical-mile", "nautical-miles"], Dimension::LENGTH, 1852.0),
    unit("mi", &["mile", "miles"], Dimension::LENGTH, 1609.344),
    unit("FL", &["flight-level"], Dimension::LENGTH, 30.48),
    unit("m/s", &["mps"], Dimension::SPEED, 1.0),
    unit("km/h", &["kmh", "kph"], Dimension::SPEED, 1000.0 / 3600.0),
    unit("kt", &["kts", "knot", "knots"], Dimension::SPEED, 1852.0 / 3600.0),
    unit("mph", &[], Dimension::SPEED, 0.44704),
    unit("ft/min", &["fpm"], Dimension::SPEED, 0.3048 / 60.0),
    unit("m/s2", &["m/s^2"], Dimension::ACCELERATION, 1.0),
    unit("deg", &["degree", "degrees"], Dimension::ANGLE, DEGREE),
    unit("rad", &["radian", "radians"], Dimension::ANGLE, 1.0),
    unit("mrad", &["milliradian", "milliradians"], Dimension::ANGLE, 1e-3),
    unit("deg/s", &["dps"], Dimension::new(0, 0, -1, 0, 0, 1), DEGREE),
    unit("rad/s", &[], Dimension::new(0, 0, -1, 0, 0, 1), 1.0),
    unit("Hz", &["hertz"], Dimension::FREQUENCY, 1.0),
    unit("kHz", &["kilohertz"], Dimension::FREQUENCY, 1e3),
    unit("MHz", &["megahertz"], Dimension::FREQUENCY, 1e6),
    unit("GHz", &["gigahertz"], Dimension::FREQUENCY, 1e9),
    unit("kg", &["kilogram", "kilograms"], Dimension::MASS, 1.0),
    unit("g", &["gram", "grams"], Dimension::MASS, 1e-3),
    unit("lb", &["lbs", "pound", "pounds"], Dimension::MASS, 0.453_592_37),
    unit("kg/h", &[], Dimension::new(0, 1, -1, 0, 0, 0), 1.0 / 3600.0),
    unit("kg/s", &[], Dimension::new(0, 1, -1, 0, 0, 0), 1.0),
    unit("V", &["volt", "volts"], Dimension::VOLTAGE, 1.0),
    unit("A", &["ampere", "amperes", "amp", "amps"], Dimension::CURRENT, 1.0),
    unit("W", &["watt", "watts"], Dimension::POWER, 1.0),
    unit("kW", &["kilowatt", "kilowatts"], Dimension::POWER, 1e3),
    unit("K", &["kelvin"], Dimension::TEMPERATURE, 1.0),
    unit("Pa", &["pascal", "pascals"], Dimension::PRESSURE, 1.0),
    unit("hPa", &["hectopascal", "hectopascals", "mbar"], Dimension::PRESSURE, 100.0),
    unit("m2", &["m^2"], Dimension::AREA, 1.0),
    unit("km2", &["km^2"], Dimension::AREA, 1e6),
    unit("acre", &["acres"], Dimension::AREA, 4_046.856_422_4),
    unit("ha", &["hectare", "hectares"], Dimension::AREA, 1e4),
];

/// Returns the unit with this spelling, in any case; the exact spelling wins where two differ by case only.
pub fn unit_named(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.name == name).or_else(|| {
        let folded = name.to_lowercase();
        UNITS.iter().find(|unit| unit.name.to_lowercase() == folded || unit.aliases.contains(&&*folded))
    })
}

/// A real number of SI units with its dimension; never dimensionless, never pure time.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct Quantity {
    /// The value in SI units.
    pub si: f64,
    /// Measured dimension.
    pub dimension: Dimension,
    /// Index in [`UNITS`] of the unit for printing; `None` prints SI base units.
    pub unit: Option<u8>,
}

impl Quantity {
    /// Returns the quantity of `number` times `unit`.
    pub fn of(number: f64, unit: &'static Unit) -> Quantity {
        let index = UNITS.iter().position(|each| std::ptr::eq(each, unit));
        Quantity {
            si: number * unit.factor,
            dimension: unit.dimension,
            unit: index.and_then(|index| u8::try_from(index).ok()),
        }
    }

    /// Returns a quantity given in SI that prints in its dimension's SI unit.
    pub fn si(si: f64, dimension: Dimension) -> Quantity {
        let unit = UNITS.iter().position(|unit| unit.dimension == dimension && unit.factor == 1.0);
        Quantity { si, dimension, unit: unit.and_then(|index| u8::try_from(index).ok()) }
    }

    /// Returns the number of `unit`s; the caller has checked the dimension.
    pub fn in_unit(&self, unit: &Unit) -> f64 {
        self.si / unit.factor
    }

    /// Returns the unit in which the quantity is printed; `None` for SI base units.
    pub fn unit(&self) -> Option<&'static Unit> {
        self.unit.and_then(|index| UNITS.get(usize::from(index)))
    }
}

impl PartialEq for Quantity {
    /// Compares value and dimension; the printing unit does not count.
    fn eq(&self, other: &Quantity) -> bool {
        self.dimension == other.dimension && self.si.to_bits() == other.si.to_bits()
    }
}

/// Formats a number with twelve significant digits without trailing zeros, which hides the last bits of a unit conversion.
pub fn format_rounded(number: f64) -> String {
    if !number.is_finite() || number == 0.0 {
        return format!("{number}");
    }
    let rounded: f64 = format!("{number:.11e}").parse().unwrap_or(number);
    format!("{rounded}")
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.unit() {
            Some(unit) if unit.name == "FL" => write!(f, "FL{}", format_rounded(self.in_unit(unit))),
            Some(unit) => write!(f, "{}{}", format_rounded(self.in_unit(unit)), unit.name),
            None => write!(f, "{} {}", format_rounded(self.si), self.dimension),
        }
    }
}

impl fmt::Debug for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aviation_units_print_as_written() {
        let height = Quantity::of(400.0, unit_named("feet").unwrap());
        assert_eq!(height.to_string(), "400ft");
        assert_eq!(Quantity::of(120.0, unit_named("FL").unwrap()).to_string(), "FL120");
        assert_eq!(Quantity::of(35.0, unit_named("KT").unwrap()).to_string(), "35kt");
    }

    #[test]
    fn case_decides_only_between_units_that_differ_by_case() {
        assert_eq!(unit_named("m").map(|unit| unit.name), Some("m"));
        assert_eq!(unit_named("mhz").map(|unit| unit.name), Some("MHz"));
        assert_eq!(unit_named("furlong"), None);
    }
}
