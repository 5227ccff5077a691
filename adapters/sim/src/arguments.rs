//! Reading the arguments of commands: numbers with their dimensions, locations, keywords. Errors are texts for the operator.

use crate::config::NamedPlace;
use crate::living::downlink::DataOrder;
use crate::names::unknown_name;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::time::Duration;
use apex_model::value::Value;

/// A location as given in a command.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spot {
    pub(crate) position: Position,
    /// Flight altitude, if the location states one.
    pub(crate) altitude_m: Option<f64>,
    /// Altitude of the object itself, for cameras; `None` is the ground.
    pub(crate) thing_altitude_m: Option<f64>,
    /// As written, for the answer.
    pub(crate) given: Value,
}

/// The step from one picture to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PictureStep {
    /// Metres over ground.
    Distance(f64),
    /// Seconds.
    Time(f64),
}

/// The direction of the nose of a rotorcraft along a path.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Nose {
    /// This heading.
    Heading(f64),
    /// Towards this place.
    Towards(Position),
}

/// A place on a way, and the altitude of the leg to it if the command states one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WayPoint {
    pub(crate) position: Position,
    pub(crate) altitude_m: Option<f64>,
}

/// Arguments of one command: positional first, then `:keyword value` pairs.
pub(crate) struct Arguments<'a> {
    command: &'a str,
    usage: &'a str,
    positional: Vec<&'a Value>,
    keywords: Vec<(String, &'a Value)>,
    places: &'a [NamedPlace],
}

impl<'a> Arguments<'a> {
    /// Splits `items` into positional arguments (between `least` and `most`) and the allowed keywords.
    pub(crate) fn split(
        command: &'a str,
        usage: &'a str,
        items: &'a [Value],
        (least, most): (usize, usize),
        allowed: &[&str],
        places: &'a [NamedPlace],
    ) -> Result<Arguments<'a>, String> {
        let mut found = Arguments { command, usage, positional: Vec::new(), keywords: Vec::new(), places };
        let mut rest = items.iter();
        while let Some(item) = rest.next() {
            let keyword = item.as_symbol().and_then(|symbol| symbol.folded().strip_prefix(':'));
            let Some(keyword) = keyword else {
                found.positional.push(item);
                continue;
            };
            if !allowed.contains(&keyword) {
                return Err(found.wrong(&unknown_name("keyword", keyword, allowed.iter().copied())));
            }
            let Some(value) = rest.next() else { return Err(found.wrong(&format!("`:{keyword}` has no value"))) };
            // An optional value that PDL did not bind arrives as nil.
            if value.is_true() {
                found.keywords.push((keyword.to_owned(), value));
            }
        }
        let count = found.positional.len();
        if count < least || count > most {
            return Err(found.wrong(&format!("it was given {count} arguments")));
        }
        Ok(found)
    }

    /// Returns a rejection: the command, the problem, and the usage.
    pub(crate) fn wrong(&self, what: &str) -> String {
        format!("{}: {what}; use {}", self.command, self.usage)
    }

    /// Returns the positional argument `index`, if given and not nil.
    pub(crate) fn at(&self, index: usize) -> Option<&'a Value> {
        self.positional.get(index).copied().filter(|value| value.is_true())
    }

    fn need(&self, index: usize, what: &str) -> Result<&'a Value, String> {
        self.at(index).ok_or_else(|| self.wrong(&format!("the {what} is missing")))
    }

    fn keyword(&self, name: &str) -> Option<&'a Value> {
        self.keywords.iter().find(|(key, _)| key == name).map(|(_, value)| *value)
    }

    fn number(&self, value: &Value, what: &str, dimension: Dimension, example: &str) -> Result<f64, String> {
        let wrong = |reason: &str| self.wrong(&format!("the {what} {value} {reason}; give for example {example}"));
        let Some((si, found)) = value.as_number() else { return Err(wrong("is not a number")) };
        if found != dimension && found != Dimension::NONE {
            return Err(wrong(&format!("is {found} and should be {dimension}")));
        }
        if !si.is_finite() {
            return Err(wrong("is not finite"));
        }
        Ok(si)
    }

    /// Returns the required positional altitude, m.
    pub(crate) fn altitude(&self, index: usize) -> Result<f64, String> {
        self.number(self.need(index, "altitude")?, "altitude", Dimension::LENGTH, "2100m or FL230")
    }

    /// Returns the required positional speed, m/s.
    pub(crate) fn speed(&self, index: usize) -> Result<f64, String> {
        self.number(self.need(index, "speed")?, "speed", Dimension::SPEED, "180kt")
    }

    /// Returns the required positional heading in radians; a bare number is degrees.
    pub(crate) fn heading(&self, index: usize) -> Result<f64, String> {
        self.angle(self.need(index, "heading")?, "heading", "270deg")
    }

    /// Returns an angle in radians; a bare number is degrees.
    fn angle(&self, value: &Value, what: &str, example: &str) -> Result<f64, String> {
        let number = self.number(value, what, Dimension::ANGLE, example)?;
        let bare = value.as_number().is_some_and(|(_, dimension)| dimension == Dimension::NONE);
        Ok(if bare { number * apex_geo::geodesy::RAD_PER_DEG } else { number })
    }

    /// Returns the required positional duration.
    pub(crate) fn duration(&self, index: usize) -> Result<Duration, String> {
        self.read_duration(self.need(index, "duration")?)
    }

    /// `:duration`, if given.
    pub(crate) fn duration_keyword(&self) -> Result<Option<Duration>, String> {
        self.keyword("duration").map(|value| self.read_duration(value)).transpose()
    }

    /// Reads `:hold` with the middle of the circle, `:hold-around`, if given.
    pub(crate) fn hold_keyword(&self) -> Result<Option<(Duration, Option<Position>)>, String> {
        let Some(value) = self.keyword("hold") else { return Ok(None) };
        let centre =
            self.keyword("hold-around").map(|value| self.read_spot(value, "middle of the circle")).transpose()?;
        Ok(Some((self.read_duration(value)?, centre.map(|spot| spot.position))))
    }

    fn read_duration(&self, value: &Value) -> Result<Duration, String> {
        let seconds = self.number(value, "duration", Dimension::TIME, "90s")?;
        if seconds < 0.0 {
            return Err(self.wrong(&format!("the duration {value} is negative")));
        }
        Ok(Duration::from_seconds(seconds))
    }

    /// `:altitude`, m, if given.
    pub(crate) fn altitude_keyword(&self) -> Result<Option<f64>, String> {
        let read = |value| self.number(value, "altitude", Dimension::LENGTH, "2100m or FL230");
        self.keyword("altitude").map(read).transpose()
    }

    /// `:speed`, m/s, if given.
    pub(crate) fn speed_keyword(&self) -> Result<Option<f64>, String> {
        self.keyword("speed").map(|value| self.number(value, "speed", Dimension::SPEED, "180kt")).transpose()
    }

    /// `:line-speed`, m/s, if given.
    pub(crate) fn line_speed_keyword(&self) -> Result<Option<f64>, String> {
        self.keyword("line-speed").map(|value| self.number(value, "line-speed", Dimension::SPEED, "50m/s")).transpose()
    }

    /// `:radius`, m, if given.
    pub(crate) fn radius_keyword(&self) -> Result<Option<f64>, String> {
        self.keyword("radius").map(|value| self.number(value, "radius", Dimension::LENGTH, "4km")).transpose()
    }

    /// `:count`, the number of pictures: 1 if not given.
    pub(crate) fn count_keyword(&self) -> Result<u32, String> {
        let Some(value) = self.keyword("count") else { return Ok(1) };
        let count = self.number(value, "count", Dimension::NONE, "3")?;
        if count.fract() != 0.0 || !(1.0..=1_000.0).contains(&count) {
            return Err(self.wrong(&format!("the count {value} is not a whole number from 1 to 1000")));
        }
        Ok(count as u32)
    }

    /// Reads the steps between pictures: `:every`, a distance over ground, or `:interval`, a time.
    pub(crate) fn picture_step(&self) -> Result<PictureStep, String> {
        let (value, what, dimension, such_as) = match (self.keyword("every"), self.keyword("interval")) {
            (Some(value), None) => (value, "distance", Dimension::LENGTH, "20m"),
            (None, Some(value)) => (value, "interval", Dimension::TIME, "2s"),
            (None, None) => return Err(self.wrong("`:every` or `:interval` is missing")),
            (Some(_), Some(_)) => return Err(self.wrong("it has both `:every` and `:interval`; give one of them")),
        };
        let step = self.number(value, what, dimension, such_as)?;
        if step <= 0.0 {
            return Err(self.wrong(&format!("the {what} {value} is not greater than zero")));
        }
        Ok(if dimension == Dimension::TIME { PictureStep::Time(step) } else { PictureStep::Distance(step) })
    }

    /// Reads `:data`, the handling of images: `store`, `stream` or `(process DELAY SHARE)`.
    pub(crate) fn data_keyword(&self) -> Result<Option<DataOrder>, String> {
        let Some(value) = self.keyword("data") else { return Ok(None) };
        let wrong =
            || self.wrong(&format!("the handling of data {value} is not store, stream or (process DELAY SHARE)"));
        if let Some(word) = value.as_symbol() {
            return match word.folded() {
                "store" => Ok(Some(DataOrder::Store)),
                "stream" => Ok(Some(DataOrder::Stream)),
                _ => Err(wrong()),
            };
        }
        let Some([Value::Symbol(head), delay, share]) = value.as_list() else { return Err(wrong()) };
        let delay_s = self.number(delay, "processing time", Dimension::TIME, "5s")?;
        let share = self.number(share, "share of the size", Dimension::NONE, "0.1")?;
        let is_right = head.is("process") && delay_s >= 0.0 && share > 0.0 && share <= 1.0;
        if is_right { Ok(Some(DataOrder::Process { delay_s, share })) } else { Err(wrong()) }
    }

    /// Reads `:nose`, the direction of the nose along a path: a heading, or the place towards which it points.
    pub(crate) fn nose_keyword(&self) -> Result<Option<Nose>, String> {
        let Some(value) = self.keyword("nose") else { return Ok(None) };
        if value.as_number().is_some() {
            let heading_rad = self.angle(value, "nose", "270deg")?;
            return Ok(Some(Nose::Heading(crate::motion::wrap_tau(heading_rad))));
        }
        self.read_spot(value, "place of the nose").map(|spot| Some(Nose::Towards(spot.position)))
    }

    /// Returns azimuth and tilt, in radians, of a direction `(along AZIMUTH TILT)`; `None` for any other argument.
    pub(crate) fn direction(&self, index: usize) -> Result<Option<(f64, f64)>, String> {
        let Some([Value::Symbol(head), rest @ ..]) = self.at(index).and_then(Value::as_list) else { return Ok(None) };
        if !head.is("along") {
            return Ok(None);
        }
        let [azimuth, tilt] = rest else { return Err(self.wrong("a direction is (along AZIMUTH TILT)")) };
        let azimuth_rad = self.angle(azimuth, "azimuth", "270deg")?;
        let tilt_rad = self.angle(tilt, "tilt", "-30deg")?;
        Ok(Some((crate::motion::wrap_tau(azimuth_rad), tilt_rad)))
    }

    /// `:centre`, if given.
    pub(crate) fn centre_keyword(&self) -> Result<Option<Position>, String> {
        let read = |value| self.read_spot(value, "centre").map(|spot| spot.position);
        self.keyword("centre").map(read).transpose()
    }

    /// `:course` in radians, if given.
    pub(crate) fn course_keyword(&self) -> Result<Option<f64>, String> {
        let read = |value| self.number(value, "course", Dimension::ANGLE, "270deg");
        self.keyword("course").map(read).transpose()
    }

    /// Reads `:via`: the locations of a path, each with the altitude of the leg to it if stated; empty if not given.
    pub(crate) fn way_keyword(&self) -> Result<Vec<WayPoint>, String> {
        let Some(value) = self.keyword("via") else { return Ok(Vec::new()) };
        let Some(items) = value.as_list() else {
            return Err(self.wrong(&format!("`:via` {value} should be a list of locations")));
        };
        items
            .iter()
            .map(|item| {
                let spot = self.read_spot(item, "place on the way")?;
                Ok(WayPoint { position: spot.position, altitude_m: spot.altitude_m })
            })
            .collect()
    }

    /// Returns the required positional list of locations, at least two.
    pub(crate) fn points(&self, index: usize) -> Result<Vec<WayPoint>, String> {
        let value = self.need(index, "path")?;
        let Some(items) = value.as_list().filter(|items| items.len() >= 2) else {
            return Err(self.wrong(&format!("the path {value} should be a list of at least two locations")));
        };
        let read = |item| {
            let spot = self.read_spot(item, "point of the path")?;
            Ok(WayPoint { position: spot.position, altitude_m: spot.altitude_m })
        };
        items.iter().map(read).collect()
    }

    /// Reads `:speeds`, m/s over ground at each of `count` points; empty if not given.
    pub(crate) fn speeds_keyword(&self, count: usize) -> Result<Vec<f64>, String> {
        let Some(value) = self.keyword("speeds") else { return Ok(Vec::new()) };
        let Some(items) = value.as_list().filter(|items| items.len() == count) else {
            return Err(self.wrong(&format!("`:speeds` should be a list of {count} speeds, one for each point")));
        };
        let read = |item| match self.number(item, "speed", Dimension::SPEED, "5m/s")? {
            speed if speed > 0.0 => Ok(speed),
            _ => Err(self.wrong(&format!("the speed {item} is not greater than zero"))),
        };
        items.iter().map(read).collect()
    }

    /// Returns the required positional location.
    pub(crate) fn spot(&self, index: usize, what: &str) -> Result<Spot, String> {
        self.read_spot(self.need(index, what)?, what)
    }

    /// Returns the positional location, if given.
    pub(crate) fn optional_spot(&self, index: usize, what: &str) -> Result<Option<Spot>, String> {
        self.at(index).map(|value| self.read_spot(value, what)).transpose()
    }

    fn read_spot(&self, value: &Value, what: &str) -> Result<Spot, String> {
        let name = match value {
            Value::Symbol(symbol) => Some(symbol.folded().to_owned()),
            Value::Text(text) => Some(text.to_lowercase()),
            _ => None,
        };
        if let Some(name) = name {
            let known = || self.places.iter().map(|place| place.name.as_str());
            let place = self.places.iter().find(|place| place.name.to_lowercase() == name);
            let place = place.ok_or_else(|| self.wrong(&unknown_name("place", &name, known())))?;
            return Ok(Spot {
                position: place.position,
                altitude_m: None,
                thing_altitude_m: place.altitude_m,
                given: value.clone(),
            });
        }
        let wrong = || {
            self.wrong(&format!(
                "the {what} {value} is not a location; give (latitude longitude [altitude]) in degrees and metres, or a place's name"
            ))
        };
        let (latitude, longitude, altitude) = match value.as_list() {
            Some([latitude, longitude]) => (latitude, longitude, None),
            Some([latitude, longitude, altitude]) => (latitude, longitude, Some(altitude)),
            _ => return Err(wrong()),
        };
        let angle = |value: &Value| match value.as_number() {
            Some((degrees, Dimension::NONE)) => Ok(degrees),
            Some((radians, Dimension::ANGLE)) => Ok(radians / apex_geo::geodesy::RAD_PER_DEG),
            _ => Err(wrong()),
        };
        let position = Position::new(angle(latitude)?, angle(longitude)?);
        let inside = position.latitude_deg.abs() <= 89.5 && position.longitude_deg.abs() <= 360.0;
        if !inside {
            return Err(self.wrong(&format!("the {what} {value} is not on Earth")));
        }
        let height = |value| self.number(value, "altitude", Dimension::LENGTH, "2100m or FL230");
        let altitude_m = altitude.map(height).transpose()?;
        Ok(Spot { position, altitude_m, thing_altitude_m: altitude_m, given: value.clone() })
    }
}
