//! The built-in functions of PDL: names, arities, purity (`pdl.md`, Forms).
//!
//! The checker resolves calls against this table; the executive evaluates exactly the names in it. A call in a checked
//! library always carries the name of [`BUILT_INS`], never an alias. Special forms (`if`, `let`, `setq`, ..) are not
//! functions: they become their own [`crate::expression::ExprKind`].
//!
//! Keyword arguments are in the argument list as constant symbols with their colon (`:prior-to`) before their value. A
//! parameter printed as FORM is a datum with holes, not an expression: `(inform (ready ?camera))`; it reaches the
//! evaluator as a constant or as [`crate::expression::ExprKind::Template`].

/// A built-in function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltIn {
    /// The name, lower case.
    pub name: &'static str,
    /// Least number of arguments.
    pub arguments_min: usize,
    /// Maximum number of arguments; `None` if it is unlimited.
    pub arguments_max: Option<usize>,
    /// True if the function has no effect and may occur everywhere; impure functions occur in hooks only.
    pub pure: bool,
    /// Parameters and result in one line, for operators.
    pub summary: &'static str,
}

const fn pure(name: &'static str, min: usize, max: usize, summary: &'static str) -> BuiltIn {
    BuiltIn { name, arguments_min: min, arguments_max: Some(max), pure: true, summary }
}

const fn any(name: &'static str, min: usize, summary: &'static str) -> BuiltIn {
    BuiltIn { name, arguments_min: min, arguments_max: None, pure: true, summary }
}

const fn effect(name: &'static str, min: usize, max: Option<usize>, summary: &'static str) -> BuiltIn {
    BuiltIn { name, arguments_min: min, arguments_max: max, pure: false, summary }
}

/// Every built-in function, sorted by name.
pub const BUILT_INS: &[BuiltIn] = &[
    any("*", 0, "number.. -> product; dimensions multiply"),
    any("+", 0, "number.. -> sum; an instant plus a duration is an instant"),
    any("-", 1, "number.. -> difference, or the negative of one; instants differ by a duration"),
    any("/", 1, "number.. -> quotient, exact for integers that divide evenly; dimensions divide"),
    any("/=", 1, "value.. -> true when no two are ="),
    pure("1+", 1, 1, "number -> number + 1"),
    pure("1-", 1, 1, "number -> number - 1"),
    any("<", 1, "number.. -> true when strictly rising; numbers of one dimension or instants"),
    any("<=", 1, "number.. -> true when never falling"),
    any("=", 1, "value.. -> true when all are equal by value: numbers, symbols, strings exactly, lists element-wise"),
    any(">", 1, "number.. -> true when strictly falling"),
    any(">=", 1, "number.. -> true when never rising"),
    pure("abs", 1, 1, "number -> its magnitude"),
    pure("acos", 1, 1, "number -> angle"),
    any("append", 0, "list.. -> one list of all items"),
    any("apply", 2, "function argument.. list -> its result, called with the arguments and the list's items"),
    pure("asin", 1, 1, "number -> angle"),
    pure("assoc", 2, 2, "key list -> the first item that is a list beginning with the key, else nil"),
    pure("atan", 1, 2, "y [x] -> angle; with x in the right quadrant"),
    pure("atom", 1, 1, "value -> true unless it is a list with items"),
    pure("ceiling", 1, 2, "number [divisor] -> the next integer above"),
    effect(
        "cogevent",
        1,
        Some(2),
        "FORM [agent] -> sends the form as an event to this agent or to the agent of that name",
    ),
    effect(
        "command",
        1,
        Some(3),
        "FORM [:timeout duration] -> sends the form to the vehicle; the primitive ends with the answer",
    ),
    effect("complete", 0, Some(1), "[value] -> ends the primitive with success and this value"),
    any("concatenate", 0, "text or symbol.. -> one string of all"),
    pure("cons", 2, 2, "item list -> the list with the item before it"),
    pure("consp", 1, 1, "value -> true for a list with items"),
    pure("cos", 1, 1, "angle -> number"),
    pure("current-value", 2, 2, "attribute object -> the latest sample's value, else nil"),
    pure("duration-of", 1, 1, "interval or task -> how long it lasted, or has lasted up to now"),
    pure("elapsed", 1, 1, "instant, interval or task -> time from it, or from its start, to now"),
    pure("elt", 2, 2, "list index -> the item, counted from 0, else nil"),
    effect("end-application", 0, Some(1), "[reason] -> ends the application"),
    pure("end-of", 1, 1, "task, interval, result or instant -> the instant of its end"),
    pure("eq", 2, 2, "value value -> true when ="),
    pure("eql", 2, 2, "value value -> true when ="),
    pure("equal", 2, 2, "value value -> true when ="),
    pure("equalp", 2, 2, "value value -> true when equal with strings in any case"),
    pure("evenp", 1, 1, "integer -> true when even"),
    pure("events-over", 2, 3, "word window -> list of (instant message) that begin with the word; see mean-over"),
    any("every", 2, "function list.. -> true when the function holds for all items"),
    pure("exp", 1, 1, "number -> e to its power"),
    pure("expt", 2, 2, "base exponent -> power"),
    pure("fifth", 1, 1, "list -> its fifth item, else nil"),
    pure("find", 2, 2, "item list -> the first item = to it, else nil"),
    pure("find-if", 2, 2, "function list -> the first item for which it holds, else nil"),
    pure("first", 1, 1, "list -> its first item, else nil"),
    pure("floor", 1, 2, "number [divisor] -> the next integer below"),
    any("format", 1, "[nil | t] control argument.. -> text; directives ~a ~s ~d ~f ~,Nf ~% ~~"),
    pure("fourth", 1, 1, "list -> its fourth item, else nil"),
    any("funcall", 1, "function argument.. -> its result"),
    pure("getf", 2, 3, "list key [default] -> the item after the key in a list of keys and values"),
    pure("in-unit", 2, 2, "quantity unit -> how many of the unit, as a real"),
    effect(
        "inform",
        1,
        Some(2),
        "FORM [router] -> sends the form to this agent, to outside and along its routers; or along one router only",
    ),
    pure("integerp", 1, 1, "value -> true for an integer"),
    pure("intern", 1, 1, "text -> the symbol of that name"),
    pure("intersection", 2, 2, "list list -> items of the first that are in the second"),
    pure("last", 1, 1, "list -> the list of its last item, else nil"),
    pure("length", 1, 1, "list or text -> its number of items or characters"),
    any("list", 0, "value.. -> the list of them"),
    pure("listp", 1, 1, "value -> true for a list, also an empty one"),
    pure("log", 1, 2, "number [base] -> logarithm, natural without base"),
    any("mapcar", 2, "function list.. -> the list of its results for each item"),
    any("max", 1, "number.. -> the greatest"),
    pure("max-over", 3, 4, "attribute object window -> the greatest sample; see mean-over"),
    pure(
        "mean-over",
        3,
        4,
        "attribute object window -> mean of samples; window: a duration up to now, an interval, or start [end]",
    ),
    pure("member", 2, 2, "item list -> the rest of the list from the first item = to it, else nil"),
    any("min", 1, "number.. -> the least"),
    pure("min-over", 3, 4, "attribute object window -> the least sample; see mean-over"),
    pure("minusp", 1, 1, "number -> true below zero"),
    pure("mod", 2, 2, "number divisor -> remainder with the divisor's sign"),
    pure(
        "most-recent-svvalue",
        2,
        4,
        "attribute object [:prior-to instant] -> the latest sample's value before the instant, else nil",
    ),
    pure("not", 1, 1, "value -> true for nil"),
    pure("nth", 2, 2, "index list -> the item, counted from 0, else nil"),
    pure("nthcdr", 2, 2, "count list -> the list without its first items"),
    pure("numberp", 1, 1, "value -> true for integers, reals, quantities and durations"),
    pure("oddp", 1, 1, "integer -> true when odd"),
    pure("plusp", 1, 1, "number -> true above zero"),
    pure("position", 2, 2, "item list -> the index of the first item = to it, else nil"),
    effect("print", 0, None, "value.. -> prints them on one line with blanks between"),
    effect(
        "publish",
        2,
        Some(3),
        "FORM value [router] -> publishes a sample of the state variable (ATTRIBUTE OBJECT); see inform",
    ),
    pure("quantity", 2, 2, "number unit -> that many of the unit, as a quantity"),
    pure("range", 1, 3, "[start] end [step] -> list of numbers from start (0) to before end by step (1)"),
    pure("realp", 1, 1, "value -> true for integers and reals"),
    pure("reduce", 2, 3, "function list [initial] -> the function folded over the items from the left"),
    pure("rem", 2, 2, "number divisor -> remainder with the number's sign"),
    pure("remove", 2, 2, "item list -> the list without items = to it"),
    pure("remove-duplicates", 1, 1, "list -> the list with the first of each = item"),
    pure("remove-if", 2, 2, "function list -> items for which it does not hold"),
    pure("remove-if-not", 2, 2, "function list -> items for which it holds"),
    effect(
        "replenish",
        1,
        Some(2),
        "RESOURCE [amount] -> adds to a renewable resource what it lacks, this amount at most",
    ),
    pure("rest", 1, 1, "list -> the list without its first item"),
    pure("reverse", 1, 1, "list or text -> the same backwards"),
    pure("round", 1, 2, "number [divisor] -> the nearest integer, halves to even"),
    pure("samples-over", 3, 4, "attribute object window -> list of (instant value); see mean-over"),
    pure("search-string", 2, 2, "part text -> the index of the part in the text, else nil"),
    pure("second", 1, 1, "list -> its second item, else nil"),
    pure("set-difference", 2, 2, "list list -> items of the first that are not in the second"),
    pure("sin", 1, 1, "angle -> number"),
    any("some", 2, "function list.. -> the first true result for the items, else nil"),
    pure("sort", 2, 4, "list function [:key function] -> the list in order of the function, stable"),
    pure("sqrt", 1, 1, "number -> square root; dimensions halve"),
    pure("start-of", 1, 1, "task, interval, result or instant -> the instant of its start"),
    pure("string-downcase", 1, 1, "text -> lower case"),
    pure("string-equal", 2, 2, "text text -> true when equal in any case"),
    pure("string-upcase", 1, 1, "text -> upper case"),
    pure("string=", 2, 2, "text text -> true when equal"),
    pure("stringp", 1, 1, "value -> true for a string"),
    pure("subseq", 2, 3, "list or text, start [end] -> the part from start to before end"),
    pure("substring", 2, 3, "text start [end] -> the part from start to before end"),
    pure("symbol-name", 1, 1, "symbol -> its name as a string"),
    pure("symbolp", 1, 1, "value -> true for a symbol"),
    pure("tan", 1, 1, "angle -> number"),
    pure("task-state", 1, 1, "task -> the symbol of its state"),
    pure("third", 1, 1, "list -> its third item, else nil"),
    pure("time-of", 1, 1, "task, interval, result or instant -> the instant of its end, as a sample's time"),
    pure("truncate", 1, 2, "number [divisor] -> the next integer towards zero"),
    pure("union", 2, 2, "list list -> items of the first, then those of the second that are not in it"),
    pure("value-at", 3, 3, "attribute object instant -> the latest sample's value at or before the instant, else nil"),
    pure("value-before", 3, 3, "attribute object instant -> the latest sample's value before the instant, else nil"),
    pure("zerop", 1, 1, "number -> true for zero"),
];

/// Other spellings of names in [`BUILT_INS`], sorted by spelling.
pub const ALIASES: &[(&str, &str)] = &[
    ("caddr", "third"),
    ("cadr", "second"),
    ("car", "first"),
    ("cdr", "rest"),
    ("concat", "concatenate"),
    ("duration", "duration-of"),
    ("duration_of", "duration-of"),
    ("end", "end-of"),
    ("end_of", "end-of"),
    ("filter", "remove-if-not"),
    ("map", "mapcar"),
    ("most-recent-value", "most-recent-svvalue"),
    ("null", "not"),
    ("start", "start-of"),
    ("start_of", "start-of"),
    ("time_of", "time-of"),
];

/// Indexicals that every agent has, without plus signs, sorted.
pub const INDEXICALS: &[&str] =
    &["beginning-of-time", "end-of-time", "met", "mission-start", "now", "pos-infinity", "self", "this-task", "tot"];

/// Functions whose values depend on more than their arguments: on time, tasks or measurements. Sorted.
pub const CHANGING: &[&str] = &[
    "current-value",
    "duration-of",
    "elapsed",
    "end-of",
    "events-over",
    "max-over",
    "mean-over",
    "min-over",
    "most-recent-svvalue",
    "samples-over",
    "start-of",
    "task-state",
    "time-of",
    "value-at",
    "value-before",
];

/// Names that head special forms, sorted.
pub const SPECIAL_FORMS: &[&str] = &[
    "and", "case", "cond", "decf", "function", "if", "incf", "lambda", "let", "let*", "or", "progn", "push", "quote",
    "setq", "unless", "when",
];

/// Returns the built-in function called `name` (folded) or by an alias; store the name in its `name` field.
pub fn built_in(name: &str) -> Option<&'static BuiltIn> {
    let name = match ALIASES.binary_search_by(|(alias, _)| (*alias).cmp(name)) {
        Ok(index) => ALIASES.get(index).map_or(name, |(_, target)| target),
        Err(_) => name,
    };
    let index = BUILT_INS.binary_search_by(|each| each.name.cmp(name)).ok()?;
    BUILT_INS.get(index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_sorted_so_that_binary_search_finds_all() {
        assert!(BUILT_INS.is_sorted_by(|a, b| a.name < b.name));
        assert!(ALIASES.is_sorted_by(|a, b| a.0 < b.0));
        assert!(INDEXICALS.is_sorted() && SPECIAL_FORMS.is_sorted() && CHANGING.is_sorted());
        assert!(CHANGING.iter().all(|name| built_in(name).is_some_and(|found| found.name == *name)));
    }

    #[test]
    fn aliases_stand_for_functions_that_exist() {
        for (alias, target) in ALIASES {
            assert_eq!(built_in(alias).map(|found| found.name), Some(*target));
            assert!(BUILT_INS.iter().all(|each| each.name != *alias), "{alias} is defined twice");
        }
    }
}
