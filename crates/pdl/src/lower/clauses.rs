//! Shapes that many forms share: keyword options, clauses that may occur once, single arguments.

use super::Lowering;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::read::Datum;
use crate::suggest::renames_marked;

/// `:name value..`: a keyword with the data up to the next keyword.
#[derive(Clone, Copy)]
pub(crate) struct KeywordGroup<'d> {
    /// The keyword, folded, without its colon.
    pub(crate) name: &'d str,
    pub(crate) span: Span,
    pub(crate) values: &'d [Datum],
}

/// Options whose value may itself be a keyword.
const KEYWORD_VALUED: &[&str] = &["quality", "estimation", "type", "use-bundles", "join"];

/// Splits `items` into keyword groups; the first part is everything before the first keyword.
pub(crate) fn groups(items: &[Datum]) -> (&[Datum], Vec<KeywordGroup<'_>>) {
    let first = items.iter().position(|item| item.keyword().is_some()).unwrap_or(items.len());
    let (before, mut rest) = items.split_at_checked(first).unwrap_or((items, &[]));
    let mut groups = Vec::new();
    while let Some((head, after)) = rest.split_first() {
        let name = head.keyword().unwrap_or("");
        let least = usize::from(KEYWORD_VALUED.contains(&name));
        let count = after
            .iter()
            .enumerate()
            .position(|(index, item)| index >= least && item.keyword().is_some())
            .unwrap_or(after.len());
        let (values, next) = after.split_at_checked(count).unwrap_or((after, &[]));
        groups.push(KeywordGroup { name, span: head.span, values });
        rest = next;
    }
    (before, groups)
}

impl Lowering {
    /// Rejects options that are unknown here or repeated.
    pub(crate) fn check_groups(&mut self, groups: &[KeywordGroup<'_>], known: &[&str], of: &str) -> Option<()> {
        let mut fine = true;
        for (index, group) in groups.iter().enumerate() {
            let earlier = groups.iter().take(index).find(|earlier| earlier.name == group.name);
            if !known.contains(&group.name) {
                fine = false;
                let message = format!("{of} has no option `:{}`", group.name);
                let diagnostic = Diagnostic::error(codes::UNKNOWN_OPTION, group.span, message);
                let list = known.iter().map(|name| format!(":{name}")).collect::<Vec<_>>().join(" ");
                let mark = |name: &str| format!(":{name}");
                let fixes = renames_marked(group.span, group.name, known.iter().copied(), mark);
                self.report(diagnostic.fixes_or_help(fixes, || format!("it knows {list}")));
            } else if group.values.is_empty() && group.name != "enabled" {
                fine = false;
                let message = format!("option `:{}` has no value", group.name);
                let diagnostic = Diagnostic::error(codes::MALFORMED, group.span, message);
                self.report(diagnostic.help("write its value after it, or remove it"));
            } else if let Some(earlier) = earlier {
                fine = false;
                self.report_twice(&format!("option `:{}`", group.name), earlier.span, group.span);
            }
        }
        fine.then_some(())
    }

    /// Reports that `what` occurs at `first` and again at `second`.
    pub(crate) fn report_twice(&mut self, what: &str, first: Span, second: Span) {
        let diagnostic = Diagnostic::error(codes::CLAUSE_TWICE, second, format!("{what} is given twice"))
            .label(first, "first given here")
            .help("keep one of them");
        self.report(diagnostic);
    }

    /// Reports a repeated clause. An equal one may be removed; of two different ones the author must choose one.
    pub(crate) fn report_clause_twice(&mut self, first: &Datum, second: &Datum) {
        let name = first.head_name();
        let same = first.to_value() == second.to_value();
        let fix =
            if same { Fix::safe("remove the second, which says the same") } else { Fix::look("remove the second") };
        let message = format!("clause `{name}` is given twice");
        let beside = second.span.start == first.span.end.saturating_add(1);
        let with_blank_before = Span { start: if beside { first.span.end } else { second.span.start }, ..second.span };
        let mut diagnostic = Diagnostic::error(codes::CLAUSE_TWICE, second.span, message)
            .label(first.span, "first given here")
            .fix(fix.replace(with_blank_before, ""));
        if name == "waitfor" {
            diagnostic = diagnostic
                .help("put all conditions into one `waitfor`: all of them must hold")
                .help("where one of several is enough, write `(waitfor (:or ..))`");
        }
        self.report(diagnostic);
    }

    /// Returns the only value of an option or clause.
    pub(crate) fn only<'d>(&mut self, name: &str, values: &'d [Datum], span: Span) -> Option<&'d Datum> {
        match values {
            [one] => Some(one),
            _ => {
                let message = format!("`{name}` takes one value, not {}", values.len());
                let diagnostic = Diagnostic::error(codes::MALFORMED, super::span_of(values, span), message);
                self.refuse(diagnostic.fixes(super::apart::apart_from_unit(values)))
            }
        }
    }

    /// Returns `Some(None)` if there is no such group, and `Some(Some(..))` if its value could be lowered.
    pub(crate) fn optional<T>(
        &mut self,
        groups: &[KeywordGroup<'_>],
        name: &str,
        lower: impl FnOnce(&mut Lowering, &Datum) -> Option<T>,
    ) -> Option<Option<T>> {
        let Some(group) = groups.iter().find(|group| group.name == name) else { return Some(None) };
        let datum = self.only(&format!(":{name}"), group.values, group.span)?;
        lower(self, datum).map(Some)
    }
}

/// Returns the values of the group called `name`, or nothing.
pub(crate) fn values_of<'d>(groups: &[KeywordGroup<'d>], name: &str) -> &'d [Datum] {
    groups.iter().find(|group| group.name == name).map_or(&[], |group| group.values)
}
