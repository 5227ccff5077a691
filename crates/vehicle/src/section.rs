//! Reading one object of a vehicle file: its members by name, unknown and repeated ones refused, figures with their sources.

use crate::error::VehicleFileError;
use crate::json::Node;

/// Members that every section may have: `source` covers its figures, `note` is for readers.
const COMMON: [&str; 2] = ["source", "note"];
const HELP_FIGURE: &str =
    "write {\"value\": 12.5, \"source\": \"where it comes from\"}, or a bare number if the section has a `source`";

/// An object of a vehicle file.
pub(crate) struct Section<'a> {
    file: &'a str,
    path: String,
    members: &'a [(String, Node)],
    has_source: bool,
}

impl<'a> Section<'a> {
    /// Opens the object `node` at `path`, whose members may be `known`, `source` and `note`.
    ///
    /// # Errors
    /// Another type, an unknown or repeated member, an empty source.
    pub(crate) fn open(
        file: &'a str,
        path: &str,
        node: &'a Node,
        known: &[&str],
    ) -> Result<Section<'a>, VehicleFileError> {
        let mut section = Section { file, path: path.to_owned(), members: &[], has_source: false };
        let Node::Object(members) = node else {
            return Err(section.wrong("", "an object", node.describe(), "write {..} with the members of this section"));
        };
        section.members = members;
        let names = || known.iter().chain(&COMMON).copied();
        for (number, (name, _)) in members.iter().enumerate() {
            if !names().any(|known| known == name) {
                let help = match nearest(name, names()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("known are {}", names().collect::<Vec<_>>().join(", ")),
                };
                return Err(section.wrong(name, "a known member", "an unknown one", &help));
            }
            if members.iter().take(number).any(|(earlier, _)| earlier == name) {
                return Err(section.wrong(name, "one value", "the member twice", "delete one of them"));
            }
        }
        section.has_source = section.text("source")?.is_some();
        section.text("note")?;
        Ok(section)
    }

    /// The file's name.
    pub(crate) fn file(&self) -> &'a str {
        self.file
    }

    /// Path of a member; of the section itself for an empty name.
    pub(crate) fn path_of(&self, name: &str) -> String {
        match (self.path.as_str(), name) {
            ("", name) => name.to_owned(),
            (path, "") => path.to_owned(),
            (path, name) => format!("{path}.{name}"),
        }
    }

    fn wrong(&self, name: &str, expected: &str, found: impl Into<String>, help: &str) -> VehicleFileError {
        VehicleFileError {
            file: self.file.to_owned(),
            path: self.path_of(name),
            expected: expected.to_owned(),
            found: found.into(),
            help: help.to_owned(),
        }
    }

    /// Returns a member; `None` if it is absent.
    pub(crate) fn member(&self, name: &str) -> Option<&'a Node> {
        self.members.iter().find(|(known, _)| known == name).map(|(_, node)| node)
    }

    /// Returns a member that must be present.
    ///
    /// # Errors
    /// It is absent; `help` says what to write.
    pub(crate) fn required(&self, name: &str, expected: &str, help: &str) -> Result<&'a Node, VehicleFileError> {
        self.member(name).ok_or_else(|| self.wrong(name, expected, "nothing", help))
    }

    /// Returns a text that is not blank; `None` if the member is absent.
    ///
    /// # Errors
    /// Another type or a blank text.
    pub(crate) fn text(&self, name: &str) -> Result<Option<&'a str>, VehicleFileError> {
        match self.member(name) {
            None => Ok(None),
            Some(Node::Text(text)) if !text.trim().is_empty() => Ok(Some(text)),
            Some(other) => {
                Err(self.wrong(name, "a text that is not blank", other.describe(), "write a text in quotes"))
            }
        }
    }

    /// Returns one figure that must be present.
    ///
    /// # Errors
    /// An absent figure, one without a source, one that is not a number.
    pub(crate) fn figure(&self, name: &str) -> Result<f64, VehicleFileError> {
        match self.sourced(name)? {
            Node::Number(number) => Ok(*number),
            other => Err(self.wrong(name, "a number", other.describe(), HELP_FIGURE)),
        }
    }

    /// Returns a figure that only vehicles of some airframe have: present if `wanted`, else zero.
    ///
    /// # Errors
    /// As [`Section::figure`]; a figure that this airframe does not have.
    pub(crate) fn figure_if(&self, name: &str, wanted: bool, airframe: &str) -> Result<f64, VehicleFileError> {
        if wanted {
            return self.figure(name);
        }
        match self.member(name) {
            None => Ok(0.0),
            Some(other) => {
                Err(self.wrong(name, &format!("nothing for a {airframe}"), other.describe(), "delete the member"))
            }
        }
    }

    /// Returns a list of numbers that must be present.
    ///
    /// # Errors
    /// As [`Section::figure`].
    pub(crate) fn figures(&self, name: &str) -> Result<Vec<f64>, VehicleFileError> {
        let found = self.sourced(name)?;
        let wrong =
            || self.wrong(name, "a list of numbers", found.describe(), "write {\"value\": [1, 2], \"source\": \"..\"}");
        let Node::List(items) = found else { return Err(wrong()) };
        let number = |item: &Node| match item {
            Node::Number(number) => Ok(*number),
            _ => Err(wrong()),
        };
        items.iter().map(number).collect()
    }

    /// Returns the value of a figure that has a source of its own or is covered by the section's.
    fn sourced(&self, name: &str) -> Result<&'a Node, VehicleFileError> {
        let found = self.required(name, "a figure with its source", HELP_FIGURE)?;
        if !matches!(found, Node::Object(_)) {
            if self.has_source {
                return Ok(found);
            }
            let bare = format!("{} without a source", found.describe());
            return Err(self.wrong(name, "a figure with its source", bare, HELP_FIGURE));
        }
        let figure = Section::open(self.file, &self.path_of(name), found, &["value"])?;
        if !figure.has_source && !self.has_source {
            return Err(self.wrong(name, "a figure with its source", "a value without a source", HELP_FIGURE));
        }
        figure.required("value", "the figure", HELP_FIGURE)
    }
}

/// Returns the candidate that resembles `name` most; `None` if none is near.
pub(crate) fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let rated = candidates.map(|candidate| (strsim::damerau_levenshtein(name, candidate), candidate));
    let (distance, candidate) = rated.min_by_key(|(distance, _)| *distance)?;
    (distance * 2 <= candidate.chars().count().max(2)).then_some(candidate)
}
