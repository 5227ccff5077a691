//! Formatter: one layout for all PDL text. Keeps every comment and every datum; formatting twice changes nothing.

mod items;
mod layout;

use crate::diagnostic::{Diagnostic, Severity};
use crate::read::read_file;
use crate::syntax::parse;

/// Number of characters per line that the formatter aims at.
pub(crate) const LINE_CHARACTERS_MAX: usize = 100;

/// Lays PDL text out: two spaces of indentation, lines of at most 100 characters, comments and data unchanged.
///
/// # Errors
/// The first syntax error of a malformed text, which remains unchanged.
#[expect(clippy::result_large_err, reason = "the message is made once and shown at once")]
pub fn format(text: &str) -> Result<String, Diagnostic> {
    format_steps(text).map(|(text, _)| text)
}

/// Like [`format`], with the line of each step of a broken form, from 1, in order.
#[expect(clippy::result_large_err, reason = "the message is made once and shown at once")]
pub(crate) fn format_steps(text: &str) -> Result<(String, Vec<u32>), Diagnostic> {
    let flaws = read_file(0, text).diagnostics;
    match flaws.into_iter().find(|each| each.severity == Severity::Error) {
        Some(flaw) => Err(flaw),
        None => Ok(layout::lay_out(&items::entries(&parse(text)))),
    }
}

#[cfg(test)]
mod tests {
    use super::format;

    fn formatted(text: &str) -> String {
        let once = format(text).unwrap();
        assert_eq!(format(&once).unwrap(), once, "a second pass changes the text");
        once
    }

    #[test]
    fn short_forms_stay_on_one_line() {
        assert_eq!(formatted("(a   (b c)\n 'd)"), "(a (b c) 'd)\n");
        assert_eq!(formatted(""), "");
    }

    #[test]
    fn comments_stay_where_they_are() {
        let text = "; first\n\n\n(a ; about a\n  ; about b\n  b #| c |#\n  )\n";
        assert_eq!(formatted(text), "; first\n\n(a ; about a\n  ; about b\n  b #| c |#)\n");
    }

    #[test]
    fn a_comment_before_the_closing_parenthesis_keeps_its_line() {
        assert_eq!(formatted("(a b ; last\n)"), "(a b ; last\n  )\n");
    }

    #[test]
    fn steps_and_options_are_laid_out_by_kind() {
        let text = "(procedure :conc (index (watch wings)) (step (refly segment visited from ?loc to +current-location+) \
                    (waitfor (:episode roll-violation (roll-angle +this-aircraft+) :quality :no-constraints :value (> +max-roll-angle-deviation+)))))";
        insta::assert_snapshot!(formatted(text));
    }

    #[test]
    fn text_with_flaws_is_refused() {
        assert_eq!(format("(a").unwrap_err().code, "E0002");
    }
}
