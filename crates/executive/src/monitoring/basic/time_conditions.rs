//! Time conditions (M&I)
//! What: detects that an instant has arrived or that a duration has passed.
//! Runs: whenever the verdict is requested; wakes the agent at the instant.
//! Reads: evaluation context.
//! Writes: the time part of a monitor.
//! Bound: O(1).
//! PDL: `(:timestamp T1 [T2])`, `(:delay D1 [D2])`.
//! Paper: Appendix B, timestamp constraints.

use crate::expression::arithmetic::{duration, instant};
use crate::expression::{EvalContext, EvaluationError, evaluate};
use crate::monitoring::part::PartContext;
use crate::monitoring::wake::WakeReason;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{Satisfaction, TimePart};
use crate::state::walk;
use apex_model::because::Evidence;
use apex_model::builtins::CHANGING;
use apex_model::evidence_list::EvidenceList;
use apex_model::expression::{Expr, ExprKind};
use apex_model::time::{Duration, Time};

/// Form of a part: instant or delay.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum TimeForm {
    /// `:timestamp`.
    Timestamp,
    /// `:delay` after the window's start.
    Delay,
}

/// Evaluates the instants again, until one of them is reached. An instant that is not known yet, such as the end of a task that
/// continues, is not an error: it counts as not reached.
pub(crate) fn advance(part: &mut TimePart, kind: TimeForm, site: PartContext, context: &dyn EvalContext) {
    if part.reached.is_some() {
        return;
    }
    part.span = span(part, kind, site.window.start, context).ok();
    let Some((from, to)) = part.span else { return };
    let first = from.max(site.window.start);
    if first <= to && first <= context.now() {
        part.reached = Some(first);
    }
}

/// Checks that the expressions of a part can be evaluated, now or later. A part that waits for a task or a value passes.
///
/// # Errors
/// Why an expression has no value.
pub(crate) fn check(
    part: &TimePart,
    kind: TimeForm,
    start: Time,
    context: &dyn EvalContext,
) -> Result<(), EvaluationError> {
    let mut exprs = std::iter::once(&part.from).chain(&part.to);
    if exprs.all(|expr| is_settled(expr, context)) {
        span(part, kind, start, context)?;
    }
    Ok(())
}

/// Returns true if the value of the expression cannot change any longer.
fn is_settled(expr: &Expr, context: &dyn EvalContext) -> bool {
    let library = context.library();
    let mut settled = true;
    walk::each(expr, &mut |part| {
        settled &= match &part.kind {
            ExprKind::Variable { name, .. } => context.variable(name).is_some(),
            ExprKind::Call { function, .. } | ExprKind::FunctionName(function) => {
                CHANGING.binary_search(&function.folded()).is_err() && !library.functions.contains_key(function)
            }
            ExprKind::Indexical(name) => !library.indexicals.contains_key(name),
            _ => true,
        };
    });
    settled
}

/// Returns the first and last instant that satisfy the part.
///
/// # Errors
/// When an expression cannot be evaluated.
pub(crate) fn span(
    part: &TimePart,
    kind: TimeForm,
    start: Time,
    context: &dyn EvalContext,
) -> Result<(Time, Time), EvaluationError> {
    match kind {
        TimeForm::Timestamp => {
            let at = |expr: &Expr| {
                let value = evaluate(expr, context)?;
                instant(&value).map_err(|message| EvaluationError { message, place: expr.place })
            };
            let from = at(&part.from)?;
            Ok((from, part.to.as_ref().map_or(Ok(from), at)?))
        }
        TimeForm::Delay => {
            let (least, most) = delays(part, context)?;
            Ok((start + least, start + most))
        }
    }
}

/// Returns the least and greatest delay.
///
/// # Errors
/// When an expression cannot be evaluated.
pub(crate) fn delays(part: &TimePart, context: &dyn EvalContext) -> Result<(Duration, Duration), EvaluationError> {
    let length = |expr: &Expr| {
        let value = evaluate(expr, context)?;
        let length = duration(&value).map_err(|message| EvaluationError { message, place: expr.place })?;
        if length < Duration::ZERO {
            let message = format!("a delay cannot be negative: {length}");
            return Err(EvaluationError { message, place: expr.place });
        }
        Ok(length)
    };
    Ok((length(&part.from)?, part.to.as_ref().map_or(Ok(Duration::MAX), length)?))
}

/// Returns the result once the instant was reached.
pub(crate) fn result(part: &TimePart, kind: TimeForm, start: Time) -> Option<Satisfaction> {
    let at = part.reached?;
    let since = matches!(kind, TimeForm::Delay).then_some(start);
    let evidence = EvidenceList::one(Evidence::Instant { since, at });
    Some(Satisfaction { interval: (at, at), recognised_at: at, bindings: Bindings::new(), evidence })
}

/// Returns the instant for which the part waits.
pub(crate) fn next_wake(part: &TimePart, kind: TimeForm, after: Time) -> Option<(Time, WakeReason)> {
    let (from, to) = part.span.filter(|_| part.reached.is_none())?;
    let what = match kind {
        TimeForm::Timestamp => WakeReason::Timestamp,
        TimeForm::Delay => WakeReason::Delay,
    };
    (from > after && from <= to).then_some((from, what))
}
