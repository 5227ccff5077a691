//! Declared messages and commands between the parts of a mission, with the types of the arguments (`docs/reference/pdl.md`, Text). The
//! checker compares programs with them; they do not affect execution.

use crate::quantity::Dimension;
use crate::source::Place;
use crate::symbol::Symbol;
use serde::{Deserialize, Serialize};

/// `(declare-event (NAME (?parameter TYPE)..) [:from SOURCE])` or `(declare-command (NAME (?parameter TYPE)..))`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InterfaceDeclaration {
    /// Parameters in order: the required ones, then the optional ones.
    pub parameters: Vec<Parameter>,
    /// Number of parameters that are required.
    pub required: usize,
    /// Options after the parameters, `:name VALUE`, that have a type (`&key`).
    #[serde(default)]
    pub options: Vec<Parameter>,
    /// True if any further arguments may follow (`&rest`, `&key`).
    pub is_open: bool,
    /// The sender of a message from outside: `vehicle`, `mission`, `operator`, `world`; `None` for the program itself.
    pub from: Option<Symbol>,
    /// Place in the source.
    pub place: Place,
}

/// A parameter with the type of its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// The name, without its question mark.
    pub name: Symbol,
    /// The type of its values.
    pub argument_type: ArgumentType,
}

/// The type of an argument of a goal, message or command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ArgumentType {
    /// A value of any type.
    Any,
    /// A number of this dimension; spans of time are of dimension time.
    Quantity(Dimension),
    /// A text.
    Text,
    /// A list.
    List,
    /// A name of this kind.
    Named(NameKind),
    /// One of these words.
    OneOf(Vec<Symbol>),
}

/// Kinds of names. A mission knows the names of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum NameKind {
    /// A target, airfield or base, or a location as a list (latitude longitude altitude).
    Place,
    /// A camera of the vehicle.
    Camera,
    /// A radio.
    Modem,
    /// An agent, which has the name of its aircraft.
    Aircraft,
}

impl NameKind {
    /// Every kind, with its word in declarations.
    pub const ALL: [(NameKind, &'static str); 4] = [
        (NameKind::Place, "place"),
        (NameKind::Camera, "camera"),
        (NameKind::Modem, "modem"),
        (NameKind::Aircraft, "aircraft"),
    ];

    /// Returns the kind that `word` declares.
    pub fn of_word(word: &str) -> Option<NameKind> {
        NameKind::ALL.into_iter().find(|(_, known)| *known == word).map(|(kind, _)| kind)
    }

    /// Returns the word of the kind in declarations.
    pub fn word(self) -> &'static str {
        NameKind::ALL.into_iter().find(|(kind, _)| *kind == self).map_or("", |(_, word)| word)
    }
}

/// Words for quantities, with their dimensions.
const QUANTITIES: &[(&str, Dimension)] = &[
    ("number", Dimension::NONE),
    ("length", Dimension::LENGTH),
    ("duration", Dimension::TIME),
    ("speed", Dimension::SPEED),
    ("angle", Dimension::ANGLE),
];

impl ArgumentType {
    /// Words that declare a type, for messages.
    pub fn words() -> impl Iterator<Item = &'static str> {
        let quantities = QUANTITIES.iter().map(|(word, _)| *word);
        let names = NameKind::ALL.into_iter().map(|(_, word)| word);
        ["any", "text", "list"].into_iter().chain(quantities).chain(names)
    }

    /// Returns the type that `word` declares.
    pub fn of_word(word: &str) -> Option<ArgumentType> {
        let quantity = || QUANTITIES.iter().find(|(known, _)| *known == word).map(|(_, dimension)| *dimension);
        match word {
            "any" => Some(ArgumentType::Any),
            "text" => Some(ArgumentType::Text),
            "list" => Some(ArgumentType::List),
            _ => quantity().map(ArgumentType::Quantity).or_else(|| NameKind::of_word(word).map(ArgumentType::Named)),
        }
    }

    /// Returns the type as text with an article: `a length`, `the name of a camera`.
    pub fn described(&self) -> String {
        match self {
            ArgumentType::Any => "anything".to_string(),
            ArgumentType::Text => "a text".to_string(),
            ArgumentType::List => "a list".to_string(),
            ArgumentType::Quantity(Dimension::TIME) => "a span of time".to_string(),
            ArgumentType::Quantity(Dimension::NONE) => "a number without unit".to_string(),
            ArgumentType::Quantity(Dimension::ANGLE) => "an angle".to_string(),
            ArgumentType::Quantity(dimension) => format!("a {dimension}"),
            ArgumentType::Named(NameKind::Place) => {
                "a place: the name of a target or airfield, or a location".to_string()
            }
            ArgumentType::Named(NameKind::Aircraft) => "the name of an agent".to_string(),
            ArgumentType::Named(kind) => format!("the name of a {}", kind.word()),
            ArgumentType::OneOf(words) => {
                let words: Vec<&str> = words.iter().map(Symbol::printed).collect();
                format!("one of {}", words.join(", "))
            }
        }
    }
}
