//! Files that map fields of a log to state variables: `(map FIELD VARIABLE ..)`, `(time COLUMN ..)`, and declarations of the state
//! variables.

use crate::mapping_doubts::{WrittenEntry, places_of_forms};
use crate::{Entry, Format, Mapping, Take, TimeName, Topic};
use apex_model::event::StateVariable;
use apex_model::library::Library;
use apex_model::quantity::{Dimension, unit_named};
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::fmt::{self, Write as _};

/// A mapping as written.
#[derive(Debug, Default)]
pub struct MappingFile {
    /// Name in messages.
    pub name: String,
    /// Fields, with the units that their numbers are in.
    pub entries: Vec<(Entry, Option<Symbol>)>,
    /// File, line and column of each of these entries that this file contains; they are the first ones.
    places: Vec<String>,
    /// The column of the time of a table.
    pub time: Option<TimeName>,
    /// Declarations of state variables by attribute, as text.
    pub declarations: Vec<(Symbol, String)>,
}

/// Reads one PDL form. An error consists of its line in the text, counted from 1, and the problem.
pub type ReadForm<'a> = &'a dyn Fn(&str) -> Result<Value, (u32, String)>;

/// A mapping that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MappingError {
    /// The failure and its place, in one line.
    pub message: String,
    /// Reason, if known.
    pub reason: Option<String>,
    /// Remedy, if known.
    pub help: Option<String>,
}

impl fmt::Display for MappingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        self.reason.iter().try_for_each(|reason| write!(f, ": {reason}"))
    }
}

impl std::error::Error for MappingError {}

/// Returns the mapping that ships for logs of `format`; `None` for formats that name their fields freely.
///
/// # Errors
/// Like [`MappingFile::parse`].
pub(crate) fn shipped(format: Format, read_form: ReadForm<'_>) -> Option<Result<MappingFile, MappingError>> {
    let (name, text) = match format {
        Format::ULog => ("px4", include_str!("../mappings/px4.pdl")),
        Format::DataFlashBinary | Format::DataFlashText => ("ardupilot", include_str!("../mappings/ardupilot.pdl")),
        Format::TelemetryLog => ("mavlink", include_str!("../mappings/mavlink.pdl")),
        Format::Mcap | Format::Csv => return None,
    };
    let parsed = MappingFile::parse(&format!("the mapping `{name}`"), text, read_form);
    Some(parsed.map(|file| MappingFile { places: Vec::new(), ..file }))
}

/// Maps every column of a table but `time` to a state variable with the column's name.
pub(crate) fn of_columns(topic: &Topic, time: Option<&str>) -> MappingFile {
    let attribute = |column: &str| -> String {
        let letter = |letter: char| if letter.is_ascii_alphanumeric() { letter.to_ascii_lowercase() } else { '-' };
        column.chars().map(letter).collect()
    };
    let columns = topic.fields.iter().filter(|column| !column.is_empty() && Some(column.as_str()) != time);
    let entries = columns.map(|column| {
        let variable = StateVariable::new(Symbol::new(&attribute(column)), Value::symbol("aircraft-1"));
        (plain(column, variable), None)
    });
    MappingFile { name: "the columns' names".to_string(), entries: entries.collect(), ..MappingFile::default() }
}

fn plain(field: &str, variable: StateVariable) -> Entry {
    let (take, words) = (Take::Value, Vec::new());
    let field = field.to_string();
    Entry { field, variable, take, scale: 1.0, integer_scale: None, offset: 0.0, words, missing: None, declared: None }
}

impl MappingFile {
    /// Reads a mapping from a text; `name` is its origin in messages.
    ///
    /// # Errors
    /// A form that is not part of a mapping.
    pub fn parse(name: &str, text: &str, read_form: ReadForm<'_>) -> Result<MappingFile, MappingError> {
        let places = places_of_forms(text);
        let place_of = |index: usize| match places.get(index) {
            Some((line, column)) => format!("{name}:{line}:{column}"),
            None => name.to_string(),
        };
        let wrong = |index: usize, form: &Value, why: String| {
            let message = format!("{}: `{}` is not a part of a mapping", place_of(index), shortened(form));
            let help = "its forms are (map \"TOPIC.FIELD\" (ATTRIBUTE OBJECT) [:unit U] [:scale N] [:integer-scale N] [:offset N] [:take roll|pitch|heading] [:missing N] [:words ((N WORD) ..)]), (time \"COLUMN\" [:unit U]) and (state-variable ..)";
            MappingError { message, reason: Some(why), help: Some(help.to_string()) }
        };
        // All forms are read as one list, opened on the line of the first form, so that line numbers in messages are those of the file.
        let whole = read_form(&format!("({text}\n)")).map_err(|(line, what)| MappingError {
            message: format!("{name}:{line}: {what}"),
            reason: None,
            help: None,
        })?;
        let mut file = MappingFile { name: name.to_string(), ..MappingFile::default() };
        for (index, form) in whole.as_list().unwrap_or_default().iter().enumerate() {
            let items = form.as_list().unwrap_or_default();
            let head = items.first().and_then(Value::as_symbol).map(Symbol::folded);
            let read = match head {
                Some("map") => entry(items).map(|entry| {
                    file.entries.push(entry);
                    file.places.push(place_of(index));
                }),
                Some("time") => time(items).map(|time| file.time = Some(time)),
                Some("state-variable") => declaration(form, items).map(|known| file.declarations.push(known)),
                _ => Err("it begins with neither `map` nor `time` nor `state-variable`".to_string()),
            };
            read.map_err(|why| wrong(index, form, why))?;
        }
        Ok(file)
    }

    /// Adds the entries of `shipped` for state variables that are not mapped here.
    pub(crate) fn add(&mut self, shipped: MappingFile) {
        let own: Vec<StateVariable> = self.entries.iter().map(|(entry, _)| entry.variable.clone()).collect();
        self.entries.extend(shipped.entries.into_iter().filter(|(entry, _)| !own.contains(&entry.variable)));
        let declared: Vec<Symbol> = self.declarations.iter().map(|(attribute, _)| attribute.clone()).collect();
        self.declarations.extend(shipped.declarations.into_iter().filter(|(each, _)| !declared.contains(each)));
    }

    /// Returns the mapping as PDL that [`MappingFile::parse`] reads.
    pub fn to_pdl(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        if let Some((column, unit_ns)) = &self.time {
            let name = unit_ns.and_then(|own| {
                ["s", "ms", "us", "ns", "min", "h"]
                    .into_iter()
                    .find(|name| unit_named(name).is_some_and(|unit| libm::rint(unit.factor * 1e9) as i64 == own))
            });
            let unit = name.map(|name| format!(" :unit {name}")).unwrap_or_default();
            let _ = writeln!(text, "(time {}{unit})", Value::text(column));
        }
        self.declarations.iter().for_each(|(_, declaration)| _ = writeln!(text, "{declaration}"));
        for (entry, unit) in &self.entries {
            let _ = write!(text, "(map {} {}", Value::text(&entry.field), entry.variable);
            let take = match entry.take {
                Take::Value => None,
                Take::Roll => Some("roll"),
                Take::Pitch => Some("pitch"),
                Take::Heading => Some("heading"),
            };
            take.into_iter().for_each(|take| _ = write!(text, " :take {take}"));
            unit.iter().for_each(|unit| _ = write!(text, " :unit {unit}"));
            let numbers = [
                ("scale", Some(entry.scale).filter(|scale| *scale != 1.0)),
                ("integer-scale", entry.integer_scale),
                ("offset", Some(entry.offset).filter(|offset| *offset != 0.0)),
                ("missing", entry.missing),
            ];
            for (name, number) in numbers {
                number.iter().for_each(|number| _ = write!(text, " :{name} {}", Value::Real(*number)));
            }
            if !entry.words.is_empty() {
                let words: Vec<String> =
                    entry.words.iter().map(|(number, word)| format!("({} {word})", Value::Real(*number))).collect();
                let _ = write!(text, " :words ({})", words.join(" "));
            }
            text.push_str(")\n");
        }
        text
    }

    /// Returns the declarations that `library` lacks, as PDL.
    pub fn declarations_beside(&self, library: &Library) -> String {
        let missing =
            self.declarations.iter().filter(|(attribute, _)| !library.state_variables.contains_key(attribute));
        missing.map(|(_, text)| format!("{text}\n")).collect()
    }

    /// Returns the mapping with numbers in the units that `library` declares.
    ///
    /// # Errors
    /// A field has a unit of another dimension than the unit declared for its state variable.
    pub fn mapping(self, library: &Library) -> Result<Mapping, MappingError> {
        let MappingFile { name, places, .. } = self;
        let written = self.entries.iter().enumerate().map(|(index, (entry, unit))| WrittenEntry {
            place: places.get(index).cloned(),
            unit: unit.clone(),
            scale: entry.scale,
        });
        let written = written.collect();
        let entries = self.entries.into_iter().enumerate().map(|(index, (mut entry, unit))| {
            let declared = library.state_variables.get(&entry.variable.attribute);
            let declared = declared.and_then(|declared| unit_named(declared.unit.as_ref()?.printed()));
            let Some(unit) = unit.and_then(|unit| unit_named(unit.printed())) else {
                entry.declared = declared.map(|to| (to.factor, to.dimension));
                return Ok(entry);
            };
            let (scale, dimension) = declared.map_or((1.0, Dimension::NONE), |to| (to.factor, to.dimension));
            if dimension != unit.dimension {
                let Entry { field, variable, .. } = &entry;
                let help = format!("declare it: (state-variable ({} ?object) :unit {})", variable.attribute, unit.name);
                return Err(MappingError {
                    message: format!("{}: the field `{field}` is in {}", places.get(index).unwrap_or(&name), unit.name),
                    reason: Some(format!("{variable} is declared as {dimension}")),
                    help: Some(help),
                });
            }
            entry.scale *= unit.factor / scale;
            entry.integer_scale = entry.integer_scale.map(|own| own * unit.factor / scale);
            entry.offset *= unit.factor / scale;
            Ok(entry)
        });
        Ok(Mapping { entries: entries.collect::<Result<_, _>>()?, written })
    }
}

fn shortened(form: &Value) -> String {
    let text = form.to_string();
    if text.chars().count() > 60 { text.chars().take(57).chain("..".chars()).collect() } else { text }
}

fn declaration(form: &Value, items: &[Value]) -> Result<(Symbol, String), String> {
    let variable = items.get(1).and_then(Value::as_list).and_then(<[Value]>::first).and_then(Value::as_symbol);
    let attribute = variable.ok_or("its second word is not (ATTRIBUTE ?object)")?;
    Ok((attribute.clone(), form.to_string()))
}

fn time(items: &[Value]) -> Result<TimeName, String> {
    let column = items.get(1).map(word).ok_or("the column is missing")?;
    let mut unit_ns = None;
    for (name, value) in options(items.get(2..).unwrap_or_default())? {
        match name.as_str() {
            ":unit" => {
                let unit = unit(value)?.filter(|unit| unit.dimension == Dimension::TIME);
                unit_ns = Some(libm::rint(unit.ok_or("the unit is not a unit of time")?.factor * 1e9) as i64);
            }
            other => return Err(format!("`{other}` has no meaning here")),
        }
    }
    Ok((column, unit_ns))
}

fn entry(items: &[Value]) -> Result<(Entry, Option<Symbol>), String> {
    let field = items.get(1).map(word).ok_or("the field is missing")?;
    let form = items.get(2).and_then(Value::as_list).unwrap_or_default();
    let (Some(attribute), objects) = (form.first().and_then(Value::as_symbol), form.get(1..).unwrap_or_default())
    else {
        return Err("its third word is not (ATTRIBUTE OBJECT)".to_string());
    };
    let object = match objects {
        [one] => one.clone(),
        several => Value::list(several.iter().cloned()),
    };
    let mut entry = plain(&field, StateVariable::new(attribute.clone(), object));
    let mut own_unit = None;
    for (name, value) in options(items.get(3..).unwrap_or_default())? {
        match name.as_str() {
            ":unit" => own_unit = unit(value)?.map(|unit| Symbol::new(unit.name)),
            ":scale" => entry.scale = factor(value)?,
            ":integer-scale" => entry.integer_scale = Some(factor(value)?),
            ":offset" => entry.offset = number(value)?,
            ":missing" => entry.missing = Some(number(value)?),
            ":take" => {
                entry.take = match word(value).as_str() {
                    "roll" => Take::Roll,
                    "pitch" => Take::Pitch,
                    "heading" => Take::Heading,
                    other => return Err(format!("`:take {other}` is not known: roll, pitch and heading are")),
                };
            }
            ":words" => {
                let pairs = value.as_list().unwrap_or_default().iter().map(|pair| match pair.as_list() {
                    Some([known, word]) => Ok((number(known)?, word.clone())),
                    _ => Err(format!("`{pair}` is not (NUMBER WORD)")),
                });
                entry.words = pairs.collect::<Result<_, String>>()?;
            }
            other => return Err(format!("`{other}` has no meaning here")),
        }
    }
    Ok((entry, own_unit))
}

fn options(items: &[Value]) -> Result<Vec<(String, &Value)>, String> {
    let pairs = items.chunks(2).map(|pair| match pair {
        [name, value] => Ok((word(name), value)),
        [name, ..] => Err(format!("`{name}` has no value")),
        [] => Err("an option is missing".to_string()),
    });
    pairs.collect()
}

fn word(value: &Value) -> String {
    match value {
        Value::Text(text) => text.to_string(),
        Value::Symbol(symbol) => symbol.printed().to_string(),
        other => other.to_string(),
    }
}

/// Returns a factor; one of 0 would make all values equal.
fn factor(value: &Value) -> Result<f64, String> {
    match number(value)? {
        0.0 => Err("a scale of 0 makes every value 0".to_string()),
        factor => Ok(factor),
    }
}

fn number(value: &Value) -> Result<f64, String> {
    match value.as_number() {
        Some((number, Dimension::NONE)) => Ok(number),
        _ => Err(format!("`{value}` is not a number")),
    }
}

fn unit(value: &Value) -> Result<Option<&'static apex_model::quantity::Unit>, String> {
    let name = word(value);
    unit_named(&name).map(Some).ok_or_else(|| format!("`{name}` is not a unit"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_form(text: &str) -> Result<Value, (u32, String)> {
        apex_pdl::read_value(text).map_err(|diagnostic| (diagnostic.span.line, diagnostic.message))
    }

    #[test]
    fn shipped_mappings_are_whole_and_their_units_fit() {
        for format in [Format::ULog, Format::DataFlashText, Format::TelemetryLog] {
            let file = shipped(format, &read_form).unwrap().unwrap();
            let declarations = file.declarations_beside(&Library::default());
            let source = apex_pdl::SourceText { name: file.name.clone(), text: declarations };
            let checked = apex_pdl::check(
                vec![source],
                apex_pdl::CheckOptions {
                    fragment: false,
                    host: &[],
                    resolve: &mut |_| Err("nothing is required".into()),
                },
            );
            assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
            let attributes: Vec<_> = file.entries.iter().map(|(entry, _)| entry.variable.attribute.clone()).collect();
            assert!(attributes.iter().all(|each| checked.library.state_variables.contains_key(each)), "{attributes:?}");
            assert!(checked.library.state_variables.keys().all(|each| attributes.contains(each)));
            file.mapping(&checked.library).unwrap();
        }
    }

    #[test]
    fn a_mapping_that_was_printed_is_read_as_the_same() {
        let own = "(time \"GPS time\" :unit ms) (map \"A.x\" (roll-angle aircraft-1) :unit deg :scale 2 :missing -1 :words ((1 up)))";
        let mut file = MappingFile::parse("own", own, &read_form).unwrap();
        file.add(shipped(Format::ULog, &read_form).unwrap().unwrap());
        let again = MappingFile::parse("own", &file.to_pdl(), &read_form).unwrap();
        assert_eq!(again.entries, file.entries);
        assert_eq!((again.time, again.declarations), (file.time, file.declarations));
        let rolls = again.entries.iter().filter(|(entry, _)| entry.variable.attribute.is("roll-angle"));
        assert_eq!(rolls.count(), 1, "the own entry replaces the one that ships");
    }

    #[test]
    fn mistakes_are_named() {
        for (text, expected) in [
            ("(mapp \"a\" (b c))", "neither `map` nor `time`"),
            ("(map \"a\" b)", "not (ATTRIBUTE OBJECT)"),
            ("(map \"a\" (b c) :unit furlong)", "`furlong` is not a unit"),
            ("(map \"a\" (b c) :take yaw)", "roll, pitch and heading are"),
            ("(map \"a\" (b c) :scale)", "`:scale` has no value"),
            ("(time \"a\" :unit m)", "the unit is not a unit of time"),
            ("\n(map \"a", "m:2:"),
            ("(map \"a;(\" (b c)) ; (\n\n  (mapp \"a\" (b c))", "m:3:3: `(mapp"),
        ] {
            let said = MappingFile::parse("m", text, &read_form).unwrap_err().to_string();
            assert!(said.contains(expected), "{text}: {said}");
        }
    }
}
