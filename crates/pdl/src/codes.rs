//! Every code that a message can carry, with one line that explains it and its page in `docs/reference/codes/`. Codes are
//! stable: a retired one is not used again.

/// A code and its explanation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ErrorCode {
    /// `E0201`: E for errors, W for warnings, N for notes. In fragments some errors appear as notes under the same code.
    pub code: &'static str,
    /// Meaning, in one line.
    pub explanation: &'static str,
    /// Its page of the documentation, in Markdown.
    pub page: &'static str,
}

macro_rules! codes {
    ($($name:ident $code:literal $explanation:literal;)*) => {
        $(pub(crate) const $name: &str = $code;)*
        /// All codes in order.
        pub(crate) const TABLE: &[ErrorCode] = &[$(ErrorCode {
            code: $code,
            explanation: $explanation,
            page: include_str!(concat!("../../../docs/reference/codes/", $code, ".md")),
        }),*];
    };
}

codes! {
    UNMATCHED_CLOSE "E0001" "A `)` closes nothing.";
    UNCLOSED_LIST "E0002" "A `(` is never closed.";
    UNCLOSED_STRING "E0003" "A string is never closed.";
    UNCLOSED_COMMENT "E0004" "A `#|` comment is never closed.";
    DANGLING_PREFIX "E0005" "A quote, backquote, comma or #' is not followed by a datum.";
    TOO_DEEP "E0006" "Lists are nested deeper than the limit.";
    TOO_LARGE "E0007" "A source text is larger than the limit.";
    NUMBER_RANGE "E0008" "A number is too large to be represented.";
    UNKNOWN_UNIT "E0009" "A number is followed by a word that is not a unit.";
    NOT_ONE_DATUM "E0010" "The text must hold exactly one datum.";
    BRACKET "E0011" "A list is written with brackets or braces.";
    TYPOGRAPHIC_QUOTE "E0012" "A string or a quote has typographic quotation marks.";
    UNKNOWN_FORM "E0101" "No top-level form has this name.";
    MALFORMED "E0102" "A form does not have the parts that it needs.";
    MISSING_INDEX "E0103" "A procedure, primitive or solver does not say which goals it serves.";
    DUPLICATE_INDEX "E0104" "Two procedures of one bundle serve exactly the same goals.";
    DUPLICATE_DEFINITION "E0105" "A name is defined twice.";
    UNKNOWN_CLAUSE "E0106" "A clause of this name does not exist here.";
    CLAUSE_TWICE "E0107" "A clause or option that may occur once is given twice.";
    UNKNOWN_OPTION "E0108" "A keyword of this name does not exist here.";
    DUPLICATE_TAG "E0109" "Two steps of one procedure have the same tag.";
    RESPONDING_WITHOUT_WAITFOR "E0110" "A responding step has no waitfor.";
    ENDLESS_REPETITION "E0111" "A step repeats without end at one instant.";
    REQUIREMENT_MISSING "E0112" "A required library or file could not be read.";
    RESOURCE_AMOUNT "E0113" "A task needs an amount of a resource that has no amounts.";
    CONSTANT_FAILS "E0114" "A constant has no value.";
    UNKNOWN_FUNCTION "E0201" "No function has this name.";
    UNKNOWN_INDEXICAL "E0202" "No indexical has this name.";
    UNKNOWN_TAG "E0203" "No step of this procedure has this tag.";
    UNBOUND_VARIABLE "E0204" "A variable is used without a binding.";
    NEVER_BOUND "E0205" "A variable that must be bound already cannot have a value.";
    ARITY "E0206" "A function is called with too few or too many arguments.";
    IMPURE "E0207" "A function with effects is called where only a value may be computed.";
    UNSERVED_GOAL "E0208" "No procedure, primitive or solver serves a goal.";
    MALFORMED_CONDITION "E0301" "A condition does not have the parts that it needs.";
    MISSING_QUALITY "E0302" "An episode does not say how dense its samples must be.";
    UNKNOWN_CONDITION "E0303" "No kind of condition has this name.";
    MALFORMED_CONSTRAINT "E0304" "A constraint is neither a comparison, a range nor a predicate.";
    DIMENSION "E0305" "Two values of different dimensions are compared or added.";
    UNDECLARED_UNIT "E0306" "A quantity is compared with a state variable whose unit is not declared.";
    VALUE_TYPE "E0307" "A value is compared with a state variable of another type.";
    DURATION_EXPECTED "E0308" "A value that is not a duration is used where a duration is needed.";
    UNSOLVABLE "E0309" "An estimated value or its time is constrained in a way that cannot be solved.";
    NOTHING_TO_PROBE "E0310" "The limits of probing permit no probe.";
    NOTHING_TO_LOG "E0311" "A limit of a log permits no sample or message.";
    DERIVATION "E0312" "A derived state variable cannot be computed.";
    ARGUMENT_TYPE "E0313" "An argument of a goal, message or command has another type than declared.";
    OPERAND "E0314" "A function is given a value of another kind than it takes.";
    WAIT_CYCLE "E0701" "Steps wait for each other in a circle.";
    NEVER_STARTS "E0702" "A step waits for an event that can never occur.";
    IMPOSSIBLE_CONDITION "E0703" "A condition can never hold.";
    RESOURCE_SHORT "E0704" "A task needs more of a resource than exists.";
    UNKNOWN_AGENT "E0801" "No agent of the application has this name.";
    UNKNOWN_ROUTER "E0802" "No router has this name.";
    UNKNOWN_BUNDLE "E0803" "No bundle has this name.";
    UNKNOWN_NAME "E0804" "The mission has no place, camera, radio or aircraft of this name.";
    REAL_EQUALITY "W0501" "Real numbers are compared for equality without a tolerance.";
    AMBIGUOUS_CHOICE "W0502" "Two procedures are equally specific for the same goal.";
    SYMBOL_LIKE_QUANTITY "W0503" "A symbol looks like a quantity with a misspelt unit.";
    SHADOWED "W0504" "A procedure, primitive or solver is never chosen.";
    UNREACHABLE "W0505" "A step or clause is never reached.";
    STARVED "W0506" "A step never gets a resource that another one keeps.";
    ENDLESS_RECURSION "W0507" "A procedure pursues itself without end.";
    WITHOUT_EFFECT "W0508" "A clause has no effect at its place.";
    POSSIBLY_UNBOUND "W0509" "A variable may have no value where it is used.";
    NOTHING_NEW "W0510" "A `:for-new` variable never has a new value.";
    UNUSED_VARIABLE "W0511" "A variable is never used.";
    UNUSED_DEFINITION "W0512" "A definition is never used.";
    RESEMBLES "W0513" "A name looks like a misspelling of another one.";
    UNBOUNDED_MEMORY "W0514" "The data that a clause keeps have no bound.";
    WORD_LIKE_VARIABLE "W0515" "A word has the name of a variable, but lacks its question mark.";
    OWN_TAG "W0516" "A pattern of a message contains the name of the waiting step.";
    NOT_PLAIN "W0517" "A priority, rank or interrupt cost has a dimension.";
    DEADLOCK "W0518" "Tasks may wait for each other's resources in a circle.";
    NEVER_SENT "W0519" "A step waits for a message that no source sends.";
    UNSERVED_ANSWER "W0520" "An answer that a question offers leads to no procedure.";
    UNKNOWN_SOLVER "W0521" "No planner has this name.";
    NO_END "N0601" "A concurrent procedure has no terminate step and no end-when clause.";
}

#[cfg(test)]
mod tests {
    use super::TABLE;

    #[test]
    fn codes_are_sorted_within_letter_and_unique() {
        for pair in TABLE.windows(2) {
            assert!(pair[0].code != pair[1].code);
            let letter = |code: &'static str| code.chars().next();
            assert!(letter(pair[0].code) != letter(pair[1].code) || pair[0].code < pair[1].code);
        }
    }
}
