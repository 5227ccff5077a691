//! Phrases: goals, activities and indexes as words, so that a question can be compared with the program; variables match anything. Words
//! of a question are read loosely: outer parentheses are optional, and case is ignored.

use apex_forms::print::Style::Brief;
use apex_model::expression::Template;
use apex_model::pattern::Pattern;
use apex_model::procedure::Activity;

/// A goal, an activity or an index, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Phrase {
    /// A word or number, folded.
    Word(String),
    /// A variable, or something computed.
    Any,
    /// Any number of parts.
    Rest,
    /// A list.
    List(Vec<Phrase>),
}

impl Phrase {
    /// Reads the words of a question.
    pub(super) fn read(text: &str) -> Phrase {
        let spaced = text.replace('(', " ( ").replace(')', " ) ");
        let mut open: Vec<Vec<Phrase>> = vec![Vec::new()];
        for word in spaced.split_whitespace() {
            match word {
                "(" => open.push(Vec::new()),
                ")" if open.len() > 1 => {
                    let list = open.pop().unwrap_or_default();
                    add(&mut open, Phrase::List(list));
                }
                ")" => {}
                word => add(&mut open, Phrase::word(word)),
            }
        }
        while open.len() > 1 {
            let list = open.pop().unwrap_or_default();
            add(&mut open, Phrase::List(list));
        }
        let mut all = open.pop().unwrap_or_default();
        match all.len() {
            1 => all.pop().unwrap_or(Phrase::Rest),
            _ => Phrase::List(all),
        }
    }

    fn word(word: &str) -> Phrase {
        let plain = word.trim_start_matches(['\'', ',', '<']);
        match plain {
            "?*" | "?+" | "??" | ".." => Phrase::Rest,
            variable if variable.starts_with('?') => Phrase::Any,
            indexical if indexical.len() > 2 && indexical.starts_with('+') && indexical.ends_with('+') => Phrase::Any,
            other => Phrase::Word(other.to_lowercase()),
        }
    }

    /// Returns an activity as written.
    pub(super) fn of_activity(activity: &Activity) -> Phrase {
        match activity {
            Activity::Goal(template) => Phrase::of_template(template),
            other => Phrase::read(&Brief.activity(other)),
        }
    }

    fn of_template(template: &Template) -> Phrase {
        match template {
            Template::Constant(value) => Phrase::read(&value.to_string()),
            Template::Hole(_) => Phrase::Any,
            Template::Splice(_) => Phrase::Rest,
            Template::List(parts) => Phrase::List(parts.iter().map(Phrase::of_template).collect()),
        }
    }

    /// Returns the index of a procedure.
    pub(super) fn of_pattern(pattern: &Pattern) -> Phrase {
        match pattern {
            Pattern::Literal(value) => Phrase::read(&value.to_string()),
            Pattern::List(parts) => Phrase::List(parts.iter().map(Phrase::of_pattern).collect()),
            Pattern::Segment { .. } | Pattern::Guard(_) => Phrase::Rest,
            Pattern::Variable(_)
            | Pattern::BoundVariable(_)
            | Pattern::Anonymous
            | Pattern::Computed(_)
            | Pattern::Is { .. }
            | Pattern::And(_)
            | Pattern::Or(_)
            | Pattern::Not(_) => Phrase::Any,
        }
    }

    /// Returns true if both can denote the same goal; variables match anything.
    pub(super) fn fits(&self, other: &Phrase) -> bool {
        match (self, other) {
            (Phrase::Any | Phrase::Rest, _) | (_, Phrase::Any | Phrase::Rest) => true,
            (Phrase::Word(a), Phrase::Word(b)) => same(a, b),
            (Phrase::List(a), Phrase::List(b)) => lists_fit(a, b),
            (Phrase::Word(_), Phrase::List(_)) | (Phrase::List(_), Phrase::Word(_)) => false,
        }
    }

    /// Returns true if the phrase is specific enough to name something: it contains more than variables.
    pub(super) fn is_telling(&self) -> bool {
        match self {
            Phrase::Word(_) => true,
            Phrase::Any | Phrase::Rest => false,
            Phrase::List(parts) => parts.iter().any(Phrase::is_telling),
        }
    }

    /// Returns true if the phrase contains the word.
    pub(super) fn mentions(&self, word: &str) -> bool {
        match self {
            Phrase::Word(own) => same(own, word),
            Phrase::Any | Phrase::Rest => false,
            Phrase::List(parts) => parts.iter().any(|part| part.mentions(word)),
        }
    }
}

fn add(open: &mut [Vec<Phrase>], phrase: Phrase) {
    if let Some(list) = open.last_mut() {
        list.push(phrase);
    }
}

fn same(a: &str, b: &str) -> bool {
    let number = |text: &str| text.parse::<f64>().ok();
    a == b || number(a).zip(number(b)).is_some_and(|(a, b)| a == b)
}

fn lists_fit(a: &[Phrase], b: &[Phrase]) -> bool {
    match (a, b) {
        ([], []) => true,
        ([Phrase::Rest, ..], _) | (_, [Phrase::Rest, ..]) => true,
        ([first, a @ ..], [second, b @ ..]) => first.fits(second) && lists_fit(a, b),
        ([], _) | (_, []) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_compared_loosely_and_variables_stand_for_anything() {
        let fits = |a: &str, b: &str| Phrase::read(a).fits(&Phrase::read(b));
        assert!(fits("take picture 3", "(Take Picture 3.0)"));
        assert!(fits("(take picture ?x)", "(take picture (34.7 -119.8))"));
        assert!(fits("(observe zaca ..)", "(observe zaca along ?lines due ?due)"));
        assert!(!fits("(take picture 3)", "(take picture 4)"));
        assert!(!fits("take", "(take picture)"));
        assert!(fits("(unclosed (list", "(unclosed (list))"));
    }

    #[test]
    fn a_word_is_found_inside() {
        let phrase = Phrase::read("(observe zaca along ((1 2)))");
        assert!(phrase.mentions("zaca") && phrase.mentions("2.0") && !phrase.mentions("lick"));
        assert!(!Phrase::read("?x").is_telling());
    }
}
