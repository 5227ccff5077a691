//! Checks texts of conditions in the terms of a library's declarations.

use crate::check::{CheckOptions, Checked, Loader, SourceText};
use crate::host::host_names;
use apex_model::condition::Condition;

/// Result of a check of conditions.
#[derive(Clone, Debug)]
pub struct CheckedConditions {
    /// The library that defines their terms, and the messages about both. Usable only if there are no errors.
    pub checked: Checked,
    /// The conditions of all texts in written order; unreadable ones are left out.
    pub conditions: Vec<Condition>,
}

/// Checks texts of conditions like [`check`] does for those of a program; `sources` declare their state variables, functions and
/// constants. Each text may contain several conditions; the texts are added to the library's sources, so that places in them are
/// described like places in files.
pub fn check_conditions(
    sources: Vec<SourceText>,
    conditions: Vec<SourceText>,
    options: CheckOptions<'_>,
) -> CheckedConditions {
    let mut loader = Loader::default();
    let fragment = options.fragment;
    let names = host_names(options.host);
    for source in sources {
        loader.load(source, fragment, options.resolve);
    }
    let first = loader.texts_read();
    for text in conditions {
        loader.read(text, false, fragment);
    }
    let texts = loader.split_off(first);
    let (checked, conditions) = loader.finish(names, fragment, true, &texts);
    CheckedConditions { checked, conditions }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render;

    fn read(declarations: &str, condition: &str) -> (CheckedConditions, String) {
        let source = |name: &str, text: &str| SourceText { name: name.to_string(), text: text.to_string() };
        let mut resolve = |_| Err("nothing is required".into());
        let options = CheckOptions { fragment: false, host: &[], resolve: &mut resolve };
        let read = check_conditions(vec![source("d.pdl", declarations)], vec![source("condition", condition)], options);
        let messages = render(&read.checked.diagnostics, &read.checked.library.sources, false);
        (read, messages)
    }

    #[test]
    fn conditions_use_what_the_library_declares() {
        let declarations =
            "(state-variable (roll-angle ?a) :unit deg) (defconstant steep 15deg) (defun half (x) (/ x 2))";
        let text =
            "(roll-angle uav > (half steep)) (:episode (roll-angle uav) :value (> steep)) :quality :no-constraints";
        let (read, messages) = read(declarations, text);
        assert_eq!((messages.as_str(), read.conditions.len()), ("", 2));
        assert_eq!(read.checked.library.describe_place(read.conditions[1].place), "condition:1:33");
        assert!(read.checked.library.procedures.is_empty());
    }

    #[test]
    fn no_task_pursues_the_goals_of_a_condition_that_stands_alone() {
        let condition = "(:or (x uav > 3) (:measurement (x uav > 5) :probing ((look at x) 5s)))";
        let (read, messages) = read("", condition);
        assert!(!read.checked.has_errors(), "{messages}");
        assert!(messages.contains("warning[W0508]: `:probing` has no effect here"), "{messages}");
        assert!(messages.contains("condition:1:54"), "{messages}");
        assert_eq!(read.conditions.len(), 1);
    }

    #[test]
    fn mistakes_are_reported_as_in_a_program() {
        let declarations = "(state-variable (roll-angle ?a) :unit deg)";
        for (condition, expected) in [
            ("(roll-angle uav > 3kt)", "E0305"),
            ("(roll-angle uav > ?limit)", "nothing binds `?limit`"),
            ("(:measurement (roll-angle uav) :value (> 15) (< 3))", "this condition can never hold"),
            ("(:episode (roll-angle uav) :value (> 15))", "quality"),
            ("(:and (roll-angle uav > 15)", "is never closed"),
            ("(x uav > (unknown 3))", "unknown"),
            ("?s1", "no step of this procedure is tagged `s1`"),
        ] {
            let (read, messages) = read(declarations, condition);
            assert!(messages.contains(expected), "{condition}: {messages}");
            assert!(read.checked.has_errors(), "{condition}: {messages}");
            assert!(messages.contains("condition:1:"), "{messages}");
        }
    }
}
