//! Settings of a mission, read from `(defapplication ..)`.

use crate::downlink::StatedDownlink;
use crate::error::{MissionError, MissionResult};
use crate::requirements::Stated;
use crate::vehicle::stated::{ModelSource, StatedVehicle, vehicle_of};
use apex_model::library::{Application, Library};
use apex_model::problem::FailureTerm;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

/// The options of an application that the command understands; all units SI.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Place of the application, for messages.
    pub place: String,
    /// Place of each option, for messages.
    pub option_places: Vec<(String, String)>,
    /// The mission's title.
    pub name: String,
    /// Source of the vehicle's model.
    pub model: ModelSource,
    /// Start of the vehicle: a location or the name of a place in the data.
    pub start: Value,
    /// Heading of the parked vehicle at the start, in degrees clockwise from north.
    pub start_heading_deg: f64,
    /// Civil time of mission time zero: seconds since 1970-01-01T00:00Z.
    pub epoch_unix_s: Option<f64>,
    /// The epoch as written, for the record.
    pub epoch_text: Option<String>,
    /// Latest end of the flight.
    pub duration: Duration,
    /// Seed of the simulated world.
    pub seed: u64,
    /// File of the targets; like all data files, relative to the mission's folder.
    pub targets: Option<String>,
    /// File of airspace zones.
    pub airspace: Option<String>,
    /// Files of elevations; the first file that contains an elevation counts.
    pub terrain: Vec<String>,
    /// Emergency landing places and bases.
    pub airfields: Option<String>,
    /// Winds that the planner assumes, in sequence.
    pub forecasts: Vec<String>,
    /// Clouds that the planner assumes.
    pub cloud_forecast: Option<String>,
    /// Wind of the simulated world.
    pub weather: Option<String>,
    /// Working times of the crew.
    pub people: Option<String>,
    /// Events that happen by the script: JSON lines as for `apex run`.
    pub scenario: Option<String>,
    /// Greatest distance from an emergency landing place, m.
    pub landing_distance_m_max: Option<f64>,
    /// Time by which a plan returns before `duration`: winds differ from the forecast and lines are flown again.
    pub end_margin: Duration,
    /// Plans of surveillance end this long before the mission.
    pub watch_margin: Duration,
    /// Time from the end of a line or a picture until its image is on the ground, as planners expect it; `None`: after the landing.
    pub images_on_ground: Option<Duration>,
    /// The downlink of images as planners assume it, for manoeuvres that state a handling of their data.
    pub downlink: Option<StatedDownlink>,
    /// Distance that flights between fires keep from the edges of airspace zones, m.
    pub zone_margin_m: f64,
    /// Distance that flights between structures keep from obstacles, m.
    pub obstacle_margin_m: f64,
    /// Requirements as written.
    pub requirements: Vec<Value>,
    /// Cost of failure, in points; zero if the mission does not state it.
    pub failure: FailureTerm,
    /// Money that one point of value represents: costs in mission data are money.
    pub value_unit: f64,
    /// Radios of the simulated world as written.
    pub modems: Vec<Value>,
    /// Radios as the planner assumes them, as PDL values.
    pub link_map: Vec<Value>,
    /// Response to the loss of a link, as written.
    pub lost_link: Vec<Value>,
    /// The dependency model of components and tests.
    pub diagnosis: Option<String>,
    /// The dynamic world of the simulation.
    pub world: Option<String>,
    /// Structures with the functions of the program that are their costs.
    pub costs: Vec<(String, Symbol)>,
}

const END_MARGIN: Duration = Duration(3_600_000_000_000);
const ZONE_MARGIN_M: f64 = 3_000.0;
const OBSTACLE_MARGIN_M: f64 = 40.0;
/// Greatest margin that a mission may state: a greater one leaves no space to fly in.
const MARGIN_M_MAX: f64 = 1e6;
/// Greatest cost that a mission may state.
const MONEY_MAX: f64 = 1e12;

const KNOWN: &[&str] = &[
    "vehicle",
    "start",
    "duration",
    "seed",
    "targets",
    "airspace",
    "terrain",
    "airfields",
    "forecast",
    "cloud-forecast",
    "weather",
    "people",
    "scenario",
    "landing-distance",
    "end-margin",
    "images-on-ground",
    "downlink",
    "zone-margin",
    "obstacle-margin",
    "failure",
    "value-unit",
    "requirements",
    "modems",
    "link-map",
    "lost-link",
    "diagnosis",
    "world",
    "costs",
    "libraries",
    "files",
    "agents",
    "routers",
    "init",
    "stop",
    "step",
    "reset",
    "type",
];

impl Settings {
    /// Returns the place of an option, otherwise that of the application: `mission.pdl:7:3`.
    pub fn place_of(&self, option: &str) -> &str {
        // A key of `:vehicle`.
        let option = if option == "model" { "vehicle" } else { option };
        let place = self.option_places.iter().find(|(known, _)| known == option);
        place.map_or(self.place.as_str(), |(_, place)| place.as_str())
    }

    /// Returns the requirements that the application states.
    pub(crate) fn stated_requirements(&self, returns: bool) -> Stated<'_> {
        Stated {
            place: self.place_of("requirements"),
            forms: &self.requirements,
            landing_distance_m_max: self.landing_distance_m_max,
            zone_margin_m: self.zone_margin_m,
            obstacle_margin_m: self.obstacle_margin_m,
            end_margin_s: returns.then(|| self.end_margin.min(self.duration).seconds()),
        }
    }
}

/// Reads the settings of the library's application.
///
/// # Errors
/// No application, or an option that is unknown or cannot be read.
pub(crate) fn read(library: &Library) -> MissionResult<Settings> {
    let Some(application) = &library.application else {
        return Err(MissionError::setting("this program is not a mission: it has no (defapplication ..)")
            .help("add one that names the vehicle, or run the program without a vehicle: `apex run PROGRAM.pdl`"));
    };
    let place = library.describe_place(application.place);
    for (key, _) in &application.options {
        if !KNOWN.contains(&key.folded()) {
            return Err(MissionError::setting(format!("unknown option :{key} of (defapplication ..)"))
                .at(library.describe_place(application.option_place(key.folded())))
                .help(format!("known are :{}", KNOWN.join(" :"))));
        }
    }
    let StatedVehicle { model, start, heading_deg } = vehicle_of(application, library)?;
    let reader = SettingsReader { application, library };
    let epoch_text = reader.text("start")?;
    let value_unit = reader.value_unit()?;
    Ok(Settings {
        place,
        option_places: (application.option_places.iter())
            .map(|(name, place)| (name.folded().to_string(), library.describe_place(*place)))
            .collect(),
        name: application.name.to_string(),
        model,
        start,
        start_heading_deg: heading_deg,
        epoch_unix_s: epoch_text.as_deref().map(|text| reader.epoch(text)).transpose()?,
        epoch_text,
        duration: reader.duration()?,
        seed: reader.seed()?,
        targets: reader.text("targets")?,
        airspace: reader.text("airspace")?,
        terrain: reader.texts("terrain")?,
        airfields: reader.text("airfields")?,
        forecasts: reader.texts("forecast")?,
        cloud_forecast: reader.text("cloud-forecast")?,
        weather: reader.text("weather")?,
        people: reader.text("people")?,
        scenario: reader.text("scenario")?,
        landing_distance_m_max: reader.length("landing-distance")?,
        end_margin: reader.end_margin()?.unwrap_or(END_MARGIN.min(Duration(reader.duration()?.0 / 2))),
        watch_margin: reader.end_margin()?.unwrap_or(Duration::ZERO),
        images_on_ground: reader.images_on_ground()?,
        downlink: crate::downlink::read(application.option("downlink"), |found, wanted| {
            reader.wrong("downlink", found, wanted)
        })?,
        zone_margin_m: reader.margin_m("zone-margin", ZONE_MARGIN_M)?,
        obstacle_margin_m: reader.margin_m("obstacle-margin", OBSTACLE_MARGIN_M)?,
        failure: reader.failure()?.in_points(value_unit),
        value_unit,
        requirements: reader.list("requirements")?,
        modems: reader.list("modems")?,
        link_map: reader.list("link-map")?,
        lost_link: reader.list("lost-link")?,
        diagnosis: reader.text("diagnosis")?,
        world: reader.text("world")?,
        costs: reader.costs()?,
    })
}

struct SettingsReader<'a> {
    application: &'a Application,
    library: &'a Library,
}

impl SettingsReader<'_> {
    fn place_of(&self, option: &str) -> String {
        self.library.describe_place(self.application.option_place(option))
    }

    fn wrong(&self, option: &str, found: &Value, wanted: &str) -> MissionError {
        MissionError::setting(format!("`:{option} {found}` cannot be read"))
            .at(self.place_of(option))
            .help(format!("write {wanted}"))
    }

    fn text(&self, option: &str) -> MissionResult<Option<String>> {
        match self.application.option(option) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(text.to_string())),
            Some(other) => Err(self.wrong(option, other, &format!("a string, for example `:{option} \"..\"`"))),
        }
    }

    /// Reads one string, or a list of strings.
    fn texts(&self, option: &str) -> MissionResult<Vec<String>> {
        let Some(Value::List(items)) = self.application.option(option) else {
            return Ok(self.text(option)?.into_iter().collect());
        };
        let text = |item: &Value| match item {
            Value::Text(text) => Ok(text.to_string()),
            other => Err(self.wrong(option, other, &format!("strings, for example `:{option} (\"..\" \"..\")`"))),
        };
        items.iter().map(text).collect()
    }

    /// Returns a list of forms; empty without the option.
    fn list(&self, option: &str) -> MissionResult<Vec<Value>> {
        match self.application.option(option) {
            None => Ok(Vec::new()),
            Some(Value::List(items)) => Ok(items.to_vec()),
            Some(other) => Err(self.wrong(option, other, &format!("a list of forms: `:{option} ((NAME ..) ..)`"))),
        }
    }

    fn duration(&self) -> MissionResult<Duration> {
        match self.application.option("duration") {
            None => Ok(Duration::from_seconds(24.0 * 3600.0)),
            Some(Value::Duration(duration)) if *duration > Duration::ZERO => Ok(*duration),
            Some(other) => Err(self.wrong("duration", other, "a positive duration: `:duration 24h`")),
        }
    }

    fn seed(&self) -> MissionResult<u64> {
        match self.application.option("seed") {
            None => Ok(1),
            Some(Value::Integer(seed)) if *seed >= 0 => Ok(seed.unsigned_abs()),
            Some(other) => Err(self.wrong("seed", other, "a whole number: `:seed 7`")),
        }
    }

    fn length(&self, option: &str) -> MissionResult<Option<f64>> {
        use apex_model::quantity::Dimension;
        match self.application.option(option).map(|value| (value, value.as_number())) {
            None => Ok(None),
            Some((_, Some((si, Dimension::LENGTH | Dimension::NONE)))) if si > 0.0 => Ok(Some(si)),
            Some((other, _)) => Err(self.wrong(option, other, &format!("a length: `:{option} 150nm`"))),
        }
    }

    fn end_margin(&self) -> MissionResult<Option<Duration>> {
        match self.application.option("end-margin") {
            None => Ok(None),
            Some(Value::Duration(margin)) if *margin >= Duration::ZERO && *margin < self.duration()? => {
                Ok(Some(*margin))
            }
            Some(other) => {
                Err(self.wrong("end-margin", other, "a duration shorter than `:duration`: `:end-margin 1h`"))
            }
        }
    }

    fn images_on_ground(&self) -> MissionResult<Option<Duration>> {
        match self.application.option("images-on-ground") {
            None => Ok(None),
            Some(Value::Duration(delay)) if *delay >= Duration::ZERO => Ok(Some(*delay)),
            Some(other) => Err(self.wrong("images-on-ground", other, "a duration: `:images-on-ground 10min`")),
        }
    }

    fn margin_m(&self, option: &str, default_m: f64) -> MissionResult<f64> {
        use apex_model::quantity::Dimension;
        match self.application.option(option).map(|value| (value, value.as_number())) {
            None => Ok(default_m),
            Some((_, Some((si, Dimension::LENGTH | Dimension::NONE)))) if (0.0..=MARGIN_M_MAX).contains(&si) => Ok(si),
            Some((other, _)) => Err(self.wrong(option, other, &format!("a length up to 1000km: `:{option} 3km`"))),
        }
    }

    /// Reads `(:probability-per-hour P :vehicle-share S :vehicle-cost C :mission-share S :mission-cost C)`, each optional.
    fn failure(&self) -> MissionResult<FailureTerm> {
        use apex_model::quantity::Dimension;
        let Some(found) = self.application.option("failure") else { return Ok(FailureTerm::default()) };
        let mut term = FailureTerm { vehicle_share: 1.0, mission_share: 1.0, ..FailureTerm::default() };
        let wrong = |what: String| {
            self.wrong("failure", found, "`:failure (:probability-per-hour 1e-4 :vehicle-share 1 :vehicle-cost 400 :mission-share 0.5 :mission-cost 300)`; shares left out are 1, costs left out are 0")
                .because(what)
        };
        let items = found.as_list().ok_or_else(|| wrong("expected a list of keys with numbers".to_string()))?;
        let mut known: Vec<&str> = Vec::new();
        for pair in items.chunks(2) {
            let [Value::Symbol(key), value] = pair else {
                return Err(wrong("expected keys, each with a number".to_string()));
            };
            let (figure, most) = match key.folded() {
                ":probability-per-hour" => (&mut term.probability_per_hour, 1.0),
                ":vehicle-share" => (&mut term.vehicle_share, 1.0),
                ":vehicle-cost" => (&mut term.vehicle_cost, MONEY_MAX),
                ":mission-share" => (&mut term.mission_share, 1.0),
                ":mission-cost" => (&mut term.mission_cost, MONEY_MAX),
                other => return Err(wrong(format!("unknown key {other}"))),
            };
            if known.contains(&key.folded()) {
                return Err(wrong(format!("{key} is given twice")));
            }
            known.push(key.folded());
            match value.as_number() {
                Some((number, Dimension::NONE)) if (0.0..=most).contains(&number) => *figure = number,
                _ => return Err(wrong(format!("{key} is {value}; expected a number from 0 to {most}"))),
            }
        }
        if !known.contains(&":probability-per-hour") {
            return Err(wrong(":probability-per-hour is missing, and without it a failure costs nothing".to_string()));
        }
        Ok(term)
    }

    fn value_unit(&self) -> MissionResult<f64> {
        use apex_model::quantity::Dimension;
        match self.application.option("value-unit").map(|value| (value, value.as_number())) {
            None => Ok(1.0),
            Some((_, Some((unit, Dimension::NONE)))) if unit > 0.0 && unit <= MONEY_MAX => Ok(unit),
            Some((other, _)) => {
                Err(self.wrong("value-unit", other, "how much money one point represents: `:value-unit 250`"))
            }
        }
    }

    /// `((TARGET FUNCTION) ..)`
    fn costs(&self) -> MissionResult<Vec<(String, Symbol)>> {
        let Some(found) = self.application.option("costs") else { return Ok(Vec::new()) };
        let wrong =
            || self.wrong("costs", found, "structures with functions: `:costs ((barn hay-cost) (school hay-cost))`");
        let pair = |item: &Value| match item.as_list() {
            Some([Value::Symbol(target), Value::Symbol(function)]) => {
                Some((target.folded().to_string(), function.clone()))
            }
            _ => None,
        };
        found.as_list().ok_or_else(wrong)?.iter().map(|item| pair(item).ok_or_else(wrong)).collect()
    }

    fn epoch(&self, text: &str) -> MissionResult<f64> {
        parse_utc(text).ok_or_else(|| {
            self.wrong("start", &Value::text(text), "a civil time with its offset: `:start \"2007-09-08T01:00:00Z\"`")
        })
    }
}

/// Returns seconds since 1970-01-01T00:00Z of an RFC 3339 time such as `2007-09-07T18:00:00-07:00`.
pub(crate) fn parse_utc(text: &str) -> Option<f64> {
    let time = OffsetDateTime::parse(text, &Rfc3339).ok()?;
    Some(time.unix_timestamp() as f64 + f64::from(time.millisecond()) / 1000.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn civil_times_are_read_with_their_offset() {
        assert_eq!(parse_utc("1970-01-02T00:00:00Z"), Some(86_400.0));
        assert_eq!(parse_utc("2007-09-07T18:00:00-07:00"), parse_utc("2007-09-08T01:00:00Z"));
        assert_eq!(parse_utc("2007-09-08T01:00:00Z"), Some(1_189_213_200.0));
        assert_eq!(parse_utc("yesterday"), None);
        assert_eq!(parse_utc("2007-13-08T01:00:00Z"), None);
    }
}
