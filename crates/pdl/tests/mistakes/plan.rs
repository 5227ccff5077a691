//! Kinds of mistakes with their frequencies.
//!
//! The mix is meant to be that of a day of writing PDL, and is fixed here so that nothing can be chosen by its result:
//! half of it misspelt words, more of those that are written more often; a fifth parentheses and quotation marks, the
//! classic problem of such a notation; the rest what is forgotten, given twice or put into the wrong order. Within a kind
//! every file is equally likely, and within a file every place. A change that leaves a program which means something
//! else, legitimately, is not a mistake and is not made: a word must be contradicted by another place of the program, or
//! belong to the vocabulary of the language.

use super::mistake::Mistake;
use super::program::Program;
use super::rng::TestRng;
use super::roles::Role;
use super::{parts, shapes, words};

type Maker = fn(&Program<'_>, &mut TestRng) -> Option<Mistake>;

/// Kinds of mistakes with their weights and makers.
pub const KINDS: &[(&str, usize, Maker)] = &[
    ("word of a goal", 14, |program, rng| words::typo(program, rng, Role::GoalWord)),
    ("word of an index", 7, |program, rng| words::typo(program, rng, Role::IndexWord)),
    ("variable", 14, |program, rng| words::typo(program, rng, Role::Variable)),
    ("tag where it is used", 10, |program, rng| words::typo(program, rng, Role::TagUse)),
    ("tag of a step", 5, |program, rng| words::typo(program, rng, Role::Tag)),
    ("clause", 10, |program, rng| words::typo(program, rng, Role::Clause)),
    ("top-level form", 4, |program, rng| words::typo(program, rng, Role::FormName)),
    ("option", 8, |program, rng| words::typo(program, rng, Role::Option)),
    ("condition", 4, |program, rng| words::typo(program, rng, Role::Condition)),
    ("built-in activity", 3, |program, rng| words::typo(program, rng, Role::Activity)),
    ("function", 8, |program, rng| words::typo(program, rng, Role::Function)),
    ("indexical", 5, |program, rng| words::typo(program, rng, Role::Indexical)),
    ("state variable", 7, |program, rng| words::typo(program, rng, Role::Attribute)),
    ("declared state variable", 2, |program, rng| words::typo(program, rng, Role::AttributeDeclared)),
    ("unit", 3, |program, rng| words::typo(program, rng, Role::Unit)),
    ("type", 2, |program, rng| words::typo(program, rng, Role::TypeName)),
    ("number with unit", 6, words::misspelt_quantity),
    ("resource", 5, |program, rng| words::typo(program, rng, Role::Resource)),
    ("library", 3, |program, rng| words::typo(program, rng, Role::Library)),
    ("event", 5, |program, rng| words::typo(program, rng, Role::EventWord)),
    ("question mark forgotten", 8, words::without_question_mark),
    ("colon forgotten", 5, words::without_colon),
    ("`)` forgotten", 16, shapes::dropped_close),
    ("`)` too many", 8, shapes::doubled_close),
    ("`(` forgotten", 4, shapes::dropped_open),
    ("step closed too early", 6, shapes::closed_too_early),
    ("step closed too late", 4, shapes::closed_too_late),
    ("quotation mark forgotten", 5, shapes::without_quote),
    ("step forgotten", 5, parts::without_step),
    ("step renamed", 4, parts::renamed_step),
    ("step waits for itself", 4, parts::waits_for_itself),
    ("tag given twice", 4, parts::same_tag),
    ("argument of a goal forgotten", 5, parts::goal_without_argument),
    ("words of a goal swapped", 4, parts::swapped_words),
    ("argument of a function forgotten", 3, parts::call_without_argument),
    ("wrong dimension", 6, words::wrong_dimension),
    ("value of an option forgotten", 3, parts::option_without_value),
    ("quality forgotten", 2, parts::without_quality),
    ("clause given twice", 3, parts::clause_twice),
    ("index forgotten", 2, parts::without_index),
    ("end forgotten", 2, parts::without_end),
    ("definition forgotten", 5, parts::without_definition),
];
