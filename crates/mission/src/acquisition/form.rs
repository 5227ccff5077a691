//! Manoeuvres in PDL notation: `(orbit :radius 60m :height 40m :turns 1)`.

use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_observation::manoeuvres::{
    Arc, ArcShape, ExpandingSquare, FlightPath, Orbit, Pirouette, SectorSearch, Side, Spiral, StandOff, Strafe,
    StraightOver, Sweep, VantagePoint,
};
use std::f64::consts::PI;

/// Degrees of one radian.
const DEG_PER_RAD: f64 = 180.0 / PI;

/// A list `(NAME :keyword value ..)`, each value read once.
pub(crate) struct Form<'a> {
    name: String,
    fields: Vec<(String, &'a Value)>,
    used: Vec<&'static str>,
}

impl<'a> Form<'a> {
    /// Reads a list; `what` names it in errors.
    ///
    /// # Errors
    /// If it is not a list of a name and keywords with values.
    pub(crate) fn read(value: &'a Value, what: &str) -> Result<Form<'a>, String> {
        let items = value.as_list().ok_or_else(|| format!("{what} {value} is not a list"))?;
        let (head, rest) = items.split_first().ok_or_else(|| format!("{what} is empty"))?;
        let name = head.as_symbol().ok_or_else(|| format!("{what} begins with {head}, not with a name"))?;
        let fields = keywords(rest, &format!("`{}`", name.folded()))?;
        Ok(Form { name: name.folded().to_string(), fields, used: Vec::new() })
    }

    /// Returns the name.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Returns a keyword's number in SI units; a bare number is in the unit of `unit_si`.
    pub(super) fn number(
        &mut self,
        key: &'static str,
        dimension: Dimension,
        unit_si: f64,
    ) -> Result<Option<f64>, String> {
        self.used.push(key);
        let Some((_, value)) = self.fields.iter().find(|(name, _)| name == key) else { return Ok(None) };
        match value.as_number() {
            Some((number, Dimension::NONE)) if number.is_finite() => Ok(Some(number * unit_si)),
            Some((number, found)) if found == dimension && number.is_finite() => Ok(Some(number)),
            _ => Err(format!("`:{key}` of `{}` is {value}, expected {dimension}", self.name)),
        }
    }

    fn need(&mut self, key: &'static str, dimension: Dimension, unit_si: f64) -> Result<f64, String> {
        let found = self.number(key, dimension, unit_si)?;
        found.ok_or_else(|| format!("`:{key}` of `{}` is missing", self.name))
    }

    pub(super) fn length(&mut self, key: &'static str) -> Result<f64, String> {
        self.need(key, Dimension::LENGTH, 1.0)
    }

    fn speed(&mut self, key: &'static str) -> Result<f64, String> {
        self.need(key, Dimension::SPEED, 1.0)
    }

    /// Returns an angle in degrees; `default` if it is not stated.
    pub(super) fn angle_deg(&mut self, key: &'static str, default: Option<f64>) -> Result<f64, String> {
        let found = self.number(key, Dimension::ANGLE, 1.0 / DEG_PER_RAD)?.map(|rad| rad * DEG_PER_RAD);
        found.or(default).ok_or_else(|| format!("`:{key}` of `{}` is missing", self.name))
    }

    pub(crate) fn optional_angle_deg(&mut self, key: &'static str) -> Result<Option<f64>, String> {
        Ok(self.number(key, Dimension::ANGLE, 1.0 / DEG_PER_RAD)?.map(|rad| rad * DEG_PER_RAD))
    }

    /// Returns a keyword's value.
    pub(crate) fn value(&mut self, key: &'static str) -> Option<&'a Value> {
        self.used.push(key);
        self.fields.iter().find(|(name, _)| name == key).map(|(_, value)| *value)
    }

    pub(crate) fn word(&mut self, key: &'static str) -> Option<String> {
        self.value(key).map(|value| value.to_string().to_lowercase())
    }

    /// Reads one of two words; returns true for the second, false for the first or without a word.
    fn is(&mut self, key: &'static str, [usual, other]: [&str; 2]) -> Result<bool, String> {
        match self.word(key).as_deref() {
            None => Ok(false),
            Some(word) if word == usual => Ok(false),
            Some(word) if word == other => Ok(true),
            Some(word) => Err(format!("`:{key}` of `{}` is {word}; write {usual} or {other}", self.name)),
        }
    }

    /// Rejects keywords that were not read.
    pub(crate) fn finish(&self) -> Result<(), String> {
        let stray = self.fields.iter().find(|(key, _)| !self.used.contains(&key.as_str()));
        stray.map_or(Ok(()), |(key, _)| {
            let known: Vec<String> = self.used.iter().map(|key| format!(":{key}")).collect();
            Err(format!("`{}` has no keyword `:{key}`; it has {}", self.name, known.join(" ")))
        })
    }
}

/// `:keyword value` pairs.
///
/// # Errors
/// A value without a keyword, a keyword without a value or twice.
pub(crate) fn keywords<'a>(items: &'a [Value], what: &str) -> Result<Vec<(String, &'a Value)>, String> {
    let mut fields: Vec<(String, &Value)> = Vec::new();
    let mut rest = items.iter();
    while let Some(item) = rest.next() {
        let key = item.as_symbol().and_then(|symbol| symbol.folded().strip_prefix(':').map(str::to_string));
        let Some(key) = key else { return Err(format!("{what}: {item} is in the place of a keyword")) };
        let Some(value) = rest.next() else { return Err(format!("{what}: `:{key}` has no value")) };
        if fields.iter().any(|(known, _)| *known == key) {
            return Err(format!("{what}: `:{key}` is given twice"));
        }
        fields.push((key, value));
    }
    Ok(fields)
}

/// Reads the flight path of a form, except for a sweep, which needs the ground of its target.
///
/// # Errors
/// The missing, unknown or wrongly typed argument.
pub(crate) fn read_path(form: &mut Form<'_>) -> Result<FlightPath, String> {
    let path = match form.name() {
        "straight-over" => FlightPath::StraightOver(StraightOver {
            track_deg: form.angle_deg("track", None)?,
            height_m: form.length("height")?,
            length_m: form.length("length")?,
            run_out_m: form.number("run-out", Dimension::LENGTH, 1.0)?.unwrap_or(0.0),
        }),
        "stand-off" => FlightPath::StandOff(StandOff {
            track_deg: form.angle_deg("track", None)?,
            side: if form.is("side", ["right", "left"])? { Side::Left } else { Side::Right },
            height_m: form.length("height")?,
            look_angle_deg: form.angle_deg("look-angle", None)?,
            length_m: form.length("length")?,
        }),
        "spiral" => FlightPath::Spiral(spiral_of(form)?),
        "orbit" => FlightPath::Orbit(Orbit {
            radius_m: form.length("radius")?,
            height_m: form.length("height")?,
            turns: form.number("turns", Dimension::NONE, 1.0)?.unwrap_or(1.0),
            from_deg: form.angle_deg("azimuth", Some(180.0))?,
            clockwise: !form.is("turning", ["right", "left"])?,
        }),
        "arc" => FlightPath::Arc(arc_of(form)?),
        "pirouette" => FlightPath::Pirouette(Pirouette {
            height_m: form.length("height")?,
            depression_deg: form.angle_deg("depression", None)?,
            overlap: form.number("overlap", Dimension::NONE, 1.0)?.unwrap_or(0.3),
            from_deg: form.angle_deg("azimuth", Some(0.0))?,
            dwell_s: form.number("dwell", Dimension::TIME, 1.0)?.unwrap_or(1.0),
        }),
        "strafe" => FlightPath::Strafe(Strafe {
            track_deg: form.angle_deg("track", None)?,
            length_m: form.length("length")?,
            distance_m: form.length("distance")?,
            height_m: form.length("height")?,
            speed_mps: form.speed("speed")?,
        }),
        "vantage-point" => FlightPath::VantagePoint(VantagePoint {
            azimuth_deg: form.angle_deg("azimuth", None)?,
            look_angle_deg: form.angle_deg("look-angle", None)?,
            slant_m: form.length("distance")?,
            dwell_s: form.number("dwell", Dimension::TIME, 1.0)?.unwrap_or(10.0),
        }),
        "expanding-square" => FlightPath::ExpandingSquare(square_of(form)?),
        "sector-search" => FlightPath::SectorSearch(SectorSearch {
            radius_m: form.length("radius")?,
            height_m: form.length("height")?,
            first_track_deg: form.optional_angle_deg("track")?,
        }),
        other => return Err(format!("there is no manoeuvre `{other}`; there are {}", FlightPath::NAMES.join(", "))),
    };
    Ok(path)
}

fn spiral_of(form: &mut Form<'_>) -> Result<Spiral, String> {
    Ok(Spiral {
        inner_radius_m: form.length("from")?,
        outer_radius_m: form.length("to")?,
        spacing_m: form.length("spacing")?,
        height_m: form.length("height")?,
        from_deg: form.angle_deg("azimuth", Some(0.0))?,
        clockwise: !form.is("turning", ["right", "left"])?,
        inward: form.is("direction", ["outward", "inward"])?,
    })
}

fn square_of(form: &mut Form<'_>) -> Result<ExpandingSquare, String> {
    let rounds = form.need("rounds", Dimension::NONE, 1.0)?;
    if rounds.fract() != 0.0 || !(1.0..=1_000.0).contains(&rounds) {
        return Err(format!("`:rounds` of `expanding-square` is {rounds}, expected a whole number from 1"));
    }
    Ok(ExpandingSquare {
        spacing_m: form.length("spacing")?,
        rounds: rounds as u32,
        height_m: form.length("height")?,
        first_track_deg: form.optional_angle_deg("track")?,
    })
}

fn arc_of(form: &mut Form<'_>) -> Result<Arc, String> {
    let radius = form.number("radius", Dimension::LENGTH, 1.0)?;
    let height = form.number("height", Dimension::LENGTH, 1.0)?;
    let shape = match (radius, height) {
        (Some(radius_m), None) => ArcShape::Arch { radius_m },
        (None, Some(height_m)) => ArcShape::Level { height_m },
        _ => return Err("`arc` needs either `:radius`, for an arch, or `:height`, for a level pass".to_string()),
    };
    Ok(Arc {
        azimuth_deg: form.angle_deg("azimuth", None)?,
        shape,
        from_elevation_deg: form.angle_deg("elevation", Some(30.0))?,
        speed_mps: form.speed("speed")?,
        turn_speed_mps: form.number("turning-speed", Dimension::SPEED, 1.0)?.unwrap_or(1.0),
        yaw_rate_deg_s: form.angle_deg("yaw-rate", Some(30.0))?,
        acceleration_mps2: form.number("acceleration", Dimension::ACCELERATION, 1.0)?.unwrap_or(0.5),
    })
}

/// Returns a flight path in PDL notation; `None` for a sweep, whose lines are printed instead.
pub(crate) fn form_of(path: &FlightPath) -> Option<Value> {
    let mut items = vec![Value::symbol(path.name())];
    let mut put = |key: &str, value: Value| items.extend([Value::symbol(&format!(":{key}")), value]);
    match path {
        FlightPath::Orbit(orbit) => {
            put("radius", metres(orbit.radius_m));
            put("height", metres(orbit.height_m));
            put("turns", Value::Real(orbit.turns));
            put("azimuth", degrees(orbit.from_deg));
            put("turning", Value::symbol(if orbit.clockwise { "right" } else { "left" }));
        }
        FlightPath::Arc(arc) => {
            match arc.shape {
                ArcShape::Arch { radius_m } => put("radius", metres(radius_m)),
                ArcShape::Level { height_m } => put("height", metres(height_m)),
            }
            put("azimuth", degrees(arc.azimuth_deg));
            put("elevation", degrees(arc.from_elevation_deg));
            put("speed", speed(arc.speed_mps));
            put("turning-speed", speed(arc.turn_speed_mps));
            put("yaw-rate", degrees(arc.yaw_rate_deg_s));
            put("acceleration", Value::measured(arc.acceleration_mps2, Dimension::ACCELERATION));
        }
        FlightPath::Spiral(spiral) => {
            put("from", metres(spiral.inner_radius_m));
            put("to", metres(spiral.outer_radius_m));
            put("spacing", metres(spiral.spacing_m));
            put("height", metres(spiral.height_m));
            put("azimuth", degrees(spiral.from_deg));
            put("turning", Value::symbol(if spiral.clockwise { "right" } else { "left" }));
            put("direction", Value::symbol(if spiral.inward { "inward" } else { "outward" }));
        }
        FlightPath::Pirouette(turn) => {
            put("height", metres(turn.height_m));
            put("depression", degrees(turn.depression_deg));
            put("overlap", Value::Real(turn.overlap));
            put("azimuth", degrees(turn.from_deg));
            put("dwell", Value::measured(turn.dwell_s, Dimension::TIME));
        }
        FlightPath::Sweep(_) => return None,
        FlightPath::StandOff(_)
        | FlightPath::StraightOver(_)
        | FlightPath::Strafe(_)
        | FlightPath::VantagePoint(_)
        | FlightPath::ExpandingSquare(_)
        | FlightPath::SectorSearch(_) => put_straight(path, &mut put),
    }
    Some(Value::list(items))
}

/// Returns the form of a sweep over all of the ground of its target.
pub(crate) fn form_of_sweep(sweep: &Sweep) -> Value {
    let mut items = vec![Value::symbol(Sweep::NAME)];
    let mut put = |key: &str, value: Value| items.extend([Value::symbol(&format!(":{key}")), value]);
    put("height", metres(sweep.height_m));
    put("swath", metres(sweep.swath_m));
    put("sidelap", Value::Real(sweep.sidelap));
    put("run-in", metres(sweep.run_in_m));
    if let Some(track_deg) = sweep.track_deg {
        put("track", degrees(track_deg));
    }
    Value::list(items)
}

/// Writes the fields of paths of straight lines, of searches and of vantage points.
fn put_straight(path: &FlightPath, put: &mut impl FnMut(&str, Value)) {
    match path {
        FlightPath::StandOff(aside) => {
            put("track", degrees(aside.track_deg));
            put("side", Value::symbol(if aside.side == Side::Left { "left" } else { "right" }));
            put("height", metres(aside.height_m));
            put("look-angle", degrees(aside.look_angle_deg));
            put("length", metres(aside.length_m));
        }
        FlightPath::StraightOver(over) => {
            put("track", degrees(over.track_deg));
            put("height", metres(over.height_m));
            put("length", metres(over.length_m));
            put("run-out", metres(over.run_out_m));
        }
        FlightPath::Strafe(strafe) => {
            put("track", degrees(strafe.track_deg));
            put("length", metres(strafe.length_m));
            put("distance", metres(strafe.distance_m));
            put("height", metres(strafe.height_m));
            put("speed", speed(strafe.speed_mps));
        }
        FlightPath::VantagePoint(place) => {
            put("azimuth", degrees(place.azimuth_deg));
            put("look-angle", degrees(place.look_angle_deg));
            put("distance", metres(place.slant_m));
            put("dwell", Value::measured(place.dwell_s, Dimension::TIME));
        }
        FlightPath::ExpandingSquare(square) => {
            put("spacing", metres(square.spacing_m));
            put("rounds", Value::Integer(i64::from(square.rounds)));
            put("height", metres(square.height_m));
            if let Some(track_deg) = square.first_track_deg {
                put("track", degrees(track_deg));
            }
        }
        FlightPath::SectorSearch(sector) => {
            put("radius", metres(sector.radius_m));
            put("height", metres(sector.height_m));
            if let Some(track_deg) = sector.first_track_deg {
                put("track", degrees(track_deg));
            }
        }
        FlightPath::Sweep(_)
        | FlightPath::Orbit(_)
        | FlightPath::Arc(_)
        | FlightPath::Spiral(_)
        | FlightPath::Pirouette(_) => {}
    }
}

fn metres(length_m: f64) -> Value {
    Value::measured(libm::round(10.0 * length_m) / 10.0, Dimension::LENGTH)
}

fn speed(speed_mps: f64) -> Value {
    Value::measured(libm::round(10.0 * speed_mps) / 10.0, Dimension::SPEED)
}

/// Returns a bare number of degrees, rounded to 0.01: an angle with its dimension is printed in radians.
fn degrees(angle_deg: f64) -> Value {
    Value::Real(libm::round(100.0 * angle_deg) / 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn form(name: &str, fields: &[(&str, f64)]) -> Value {
        let fields = fields.iter();
        let fields = fields.flat_map(|(key, number)| [Value::symbol(&format!(":{key}")), Value::Real(*number)]);
        Value::list(std::iter::once(Value::symbol(name)).chain(fields))
    }

    fn path_of(value: &Value) -> Result<FlightPath, String> {
        let mut form = Form::read(value, "the manoeuvre")?;
        let path = read_path(&mut form)?;
        form.finish().map(|()| path)
    }

    #[test]
    fn every_form_is_read_back_as_it_is_printed() {
        let all = [
            form("straight-over", &[("track", 30.0), ("height", 60.0), ("length", 200.0)]),
            form("stand-off", &[("track", 30.0), ("height", 60.0), ("length", 200.0), ("look-angle", 45.0)]),
            form("spiral", &[("from", 30.0), ("to", 60.0), ("spacing", 20.0), ("height", 45.0)]),
            form("orbit", &[("radius", 30.0), ("height", 60.0), ("turns", 2.5)]),
            form("arc", &[("radius", 80.0), ("azimuth", 90.0), ("speed", 3.0)]),
            form("arc", &[("height", 80.0), ("azimuth", 90.0), ("speed", 3.0)]),
            form("pirouette", &[("height", 60.0), ("depression", 45.0)]),
            form("strafe", &[("track", 30.0), ("length", 60.0), ("distance", 40.0), ("height", 20.0), ("speed", 4.0)]),
            form("vantage-point", &[("azimuth", 30.0), ("look-angle", 40.0), ("distance", 80.0)]),
            form("expanding-square", &[("spacing", 80.0), ("rounds", 3.0), ("height", 60.0)]),
            form("sector-search", &[("radius", 300.0), ("height", 60.0), ("track", 10.0)]),
        ];
        for written in all {
            let path = path_of(&written).unwrap();
            let printed = form_of(&path).unwrap_or_else(Value::nil);
            // Angles pass through radians, so the last digit may change; printing again gives the same form.
            let again = path_of(&printed).ok().and_then(|path| form_of(&path)).map(|form| form.to_string());
            assert_eq!(again, Some(printed.to_string()), "{written} printed as {printed}");
        }
    }

    #[test]
    fn mistakes_say_what_to_write() {
        let why = |value: &Value| path_of(value).map(|_| ()).err().unwrap_or_default();
        assert!(why(&form("orbits", &[])).starts_with("there is no manoeuvre `orbits`; there are straight-over, "));
        assert_eq!(why(&form("orbit", &[("radius", 30.0)])), "`:height` of `orbit` is missing");
        assert_eq!(
            why(&form("orbit", &[("radius", 30.0), ("height", 1.0), ("laps", 2.0)])),
            "`orbit` has no keyword `:laps`; it has :radius :height :turns :azimuth :turning"
        );
        assert!(why(&form("arc", &[("azimuth", 30.0), ("speed", 1.0)])).contains("either `:radius`"));
        assert!(why(&form("expanding-square", &[("rounds", 2.5)])).contains("expected a whole number"));
    }
}
