//! Reading one object of a vehicle file: members by name, figures with their sources. Unknown and repeated members are rejected.

use crate::error::{FileName, VehicleFileError};
use crate::json::Node;

/// Members that every section may have: `source` covers its figures, `note` is for readers.
const COMMON: [&str; 2] = ["source", "note"];
const HELP_FIGURE: &str =
    "write {\"value\": 12.5, \"source\": \"where it comes from\"}, or a bare number if the section has a `source`";

/// An object of a vehicle file.
pub(crate) struct Section<'a> {
    file: FileName<'a>,
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
        file: FileName<'a>,
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

    /// Returns the file's name.
    pub(crate) fn file(&self) -> FileName<'a> {
        self.file
    }

    /// Returns the path of a member; of the section itself for an empty name.
    pub(crate) fn path_of(&self, name: &str) -> String {
        match (self.path.as_str(), name) {
            ("", name) => name.to_owned(),
            (path, "") => path.to_owned(),
            (path, name) => format!("{path}.{name}"),
        }
    }

    /// Returns an error at the member `name`.
    pub(crate) fn wrong(&self, name: &str, expected: &str, found: impl Into<String>, help: &str) -> VehicleFileError {
        self.file.error(self.path_of(name), expected, found, help)
    }

    /// Returns a member, or `None` if it is absent.
    pub(crate) fn member(&self, name: &str) -> Option<&'a Node> {
        self.members.iter().find(|(known, _)| known == name).map(|(_, node)| node)
    }

    /// Returns a member that must be present.
    ///
    /// # Errors
    /// The member is absent; `help` is the advice on what to write.
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
    /// A figure that is absent, has no source, or is not a number.
    pub(crate) fn figure(&self, name: &str) -> Result<f64, VehicleFileError> {
        match self.sourced(name)? {
            Node::Number(number) => Ok(*number),
            other => Err(self.wrong(name, "a number", other.describe(), HELP_FIGURE)),
        }
    }

    /// Returns one figure, or `None` if the member is absent.
    ///
    /// # Errors
    /// Like [`Section::figure`].
    pub(crate) fn figure_optional(&self, name: &str) -> Result<Option<f64>, VehicleFileError> {
        self.member(name).map(|_| self.figure(name)).transpose()
    }

    /// Returns `true` or `false`, which must be present.
    ///
    /// # Errors
    /// A member that is absent or of the wrong type.
    pub(crate) fn truth(&self, name: &str) -> Result<bool, VehicleFileError> {
        const HELP: &str = "write true or false";
        match self.required(name, "true or false", HELP)? {
            Node::Bool(truth) => Ok(*truth),
            other => Err(self.wrong(name, "true or false", other.describe(), HELP)),
        }
    }

    /// Returns the objects of a list, each with its path; an absent list has none.
    ///
    /// # Errors
    /// Another type.
    pub(crate) fn items(&self, name: &str) -> Result<Vec<(String, &'a Node)>, VehicleFileError> {
        match self.member(name) {
            None => Ok(Vec::new()),
            Some(Node::List(items)) => {
                let path = |number| format!("{}[{number}]", self.path_of(name));
                Ok(items.iter().enumerate().map(|(number, node)| (path(number), node)).collect())
            }
            Some(other) => {
                let help = "write [..] with one object for each, or leave it out";
                Err(self.wrong(name, "a list of objects", other.describe(), help))
            }
        }
    }

    /// Returns a text that must be one of `known`.
    ///
    /// # Errors
    /// An absent member, another type, another text.
    pub(crate) fn word(&self, member: &str, known: &[&'static str]) -> Result<&'a str, VehicleFileError> {
        let choices = || known.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ");
        let help = format!("write \"{member}\": {}", choices());
        let found = self.required(member, &choices(), &help)?;
        match self.text(member)? {
            Some(text) if known.contains(&text) => Ok(text),
            text => {
                let near = text.and_then(|text| nearest(text, known.iter().copied()));
                let help = near.map_or(help, |near| format!("did you mean \"{near}\"?"));
                Err(self.wrong(member, &choices(), found.describe(), &help))
            }
        }
    }

    /// Returns the text `name`, which must be present.
    ///
    /// # Errors
    /// Like [`Section::text`]; an absent member.
    pub(crate) fn name(&self, example: &str) -> Result<String, VehicleFileError> {
        self.required("name", "a text", &format!("write \"name\": \"{example}\""))?;
        Ok(self.text("name")?.unwrap_or_default().to_owned())
    }

    /// Returns a figure that only vehicles of some airframes have: it must be present if `wanted`, and is zero otherwise.
    ///
    /// # Errors
    /// The errors of [`Section::figure`]; also a figure that this airframe does not have.
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
    /// Like [`Section::figure`].
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

    /// Returns the value of a figure that has a source, or is covered by the source of the section.
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
