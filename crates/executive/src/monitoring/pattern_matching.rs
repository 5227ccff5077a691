//! Pattern matching (M&I)
//! What: matches a value against a pattern with variables, segments and guards.
//! Runs: on messages and samples, at procedure selection.
//! Reads: evaluation context.
//! Writes: bindings.
//! Bound: `MATCH_STEPS_MAX` steps; without segments linear in the pattern.
//! PDL: section 2.
//! Paper: section III, pattern matching.

use crate::expression::{EvalContext, EvaluationError, WithBindings, evaluate};
use crate::state::bindings::Bindings;
use apex_model::expression::{Expr, ExprKind};
use apex_model::limits::MATCH_STEPS_MAX;
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::rc::Rc;

/// Returns true if `value` matches `pattern`. Variables that are bound in `bindings` or `context` must match their values; others are
/// added to `bindings`, which is unchanged without a match or on an error. Segments take as few elements as possible. `place` is the
/// place of errors without a place.
///
/// # Errors
/// When a computed part, guard or predicate fails, a `<?x>` is unbound, or the match takes too many steps.
pub(crate) fn match_pattern(
    pattern: &Pattern,
    value: &Value,
    bindings: &mut Bindings,
    context: &dyn EvalContext,
    place: Place,
) -> Result<bool, EvaluationError> {
    let mut steps = 0;
    let length = bindings.len();
    let straight = is_straight(pattern);
    let mut matcher = Matcher { bindings, context, place, steps: &mut steps };
    let result = if straight { matcher.straight(pattern, value) } else { matcher.solve(Goal::One(pattern, value)) };
    if !matches!(result, Ok(true)) {
        bindings.truncate(length);
    }
    result
}

/// Returns true if the pattern can match in one way only, without backtracking, as most patterns do.
fn is_straight(pattern: &Pattern) -> bool {
    match pattern {
        Pattern::Literal(_) | Pattern::Variable(_) | Pattern::BoundVariable(_) | Pattern::Anonymous => true,
        Pattern::Computed(_) | Pattern::Is { .. } => true,
        Pattern::List(parts) => parts.iter().all(is_straight),
        Pattern::Guard(_) | Pattern::Segment { .. } | Pattern::And(_) | Pattern::Or(_) | Pattern::Not(_) => false,
    }
}

/// Remaining patterns to match.
#[derive(Clone, Copy)]
enum Goal<'a> {
    One(&'a Pattern, &'a Value),
    Sequence(&'a [Pattern], &'a [Value]),
}

/// A goal and its successors. Its length is bounded by the depth of the pattern, not by the length of a list.
struct GoalStack<'a> {
    goal: Goal<'a>,
    next: Goals<'a>,
}

type Goals<'a> = Option<Rc<GoalStack<'a>>>;

/// Alternative to try if the present one fails.
struct ChoicePoint<'a> {
    goal: Goal<'a>,
    next: Goals<'a>,
    bound: usize,
    /// For a segment at the head of the goal: how many elements to take. For `(?or ..)`: which alternative.
    attempt: usize,
}

struct Matcher<'a> {
    bindings: &'a mut Bindings,
    context: &'a dyn EvalContext,
    place: Place,
    steps: &'a mut u64,
}

/// Result of one step.
enum MatchStep<'a> {
    Fail,
    Continue(Goals<'a>),
}

impl Matcher<'_> {
    /// Matches a straight pattern, part by part. The recursion is as deep as the pattern, which the reader bounds.
    fn straight(&mut self, pattern: &Pattern, value: &Value) -> Result<bool, EvaluationError> {
        match pattern {
            Pattern::List(parts) => {
                let Some(values) = value.as_list() else { return Ok(false) };
                for (part, value) in parts.iter().zip(values) {
                    if !self.straight(part, value)? {
                        return Ok(false);
                    }
                }
                Ok(parts.len() == values.len())
            }
            _ => self.simple(pattern, value).map(|holds| holds.unwrap_or(false)),
        }
    }

    /// Returns the outcome of a pattern without parts; `None` for other patterns.
    fn simple(&mut self, pattern: &Pattern, value: &Value) -> Result<Option<bool>, EvaluationError> {
        Ok(Some(match pattern {
            Pattern::Literal(literal) => literal.matches(value),
            Pattern::Variable(name) => self.bind(name, value),
            Pattern::BoundVariable(name) => self
                .lookup(name)
                .ok_or_else(|| self.error(format!("<?{name}> must have a value already, but has none here")))?
                .matches(value),
            Pattern::Anonymous => true,
            Pattern::Computed(expr) => self.evaluate(expr)?.matches(value),
            Pattern::Guard(expr) => self.evaluate(expr)?.is_true(),
            Pattern::Is { variable, predicate } => self.holds(predicate, value)? && self.bind(variable, value),
            // A segment outside of a list has no surrounding elements to take.
            Pattern::Segment { .. } => false,
            Pattern::List(_) | Pattern::And(_) | Pattern::Or(_) | Pattern::Not(_) => return Ok(None),
        }))
    }

    fn solve<'p>(&mut self, goal: Goal<'p>) -> Result<bool, EvaluationError> {
        let mut goals: Goals<'p> = Some(Rc::new(GoalStack { goal, next: None }));
        let mut choices: Vec<ChoicePoint<'p>> = Vec::new();
        loop {
            let Some(node) = goals else { return Ok(true) };
            // Without alternatives, the number of steps is bounded by the size of the pattern and is not counted.
            *self.steps += u64::from(!choices.is_empty());
            if *self.steps > MATCH_STEPS_MAX {
                return Err(self.error(format!("the match takes more than MATCH_STEPS_MAX = {MATCH_STEPS_MAX} steps")));
            }
            let mut progress = self.advance(node.goal, &node.next, 0, &mut choices)?;
            while let MatchStep::Fail = progress {
                let Some(choice) = choices.pop() else { return Ok(false) };
                *self.steps += 1;
                self.bindings.truncate(choice.bound);
                progress = self.advance(choice.goal, &choice.next, choice.attempt, &mut choices)?;
            }
            let MatchStep::Continue(next) = progress else { return Ok(false) };
            goals = next;
        }
    }

    fn advance<'p>(
        &mut self,
        goal: Goal<'p>,
        next: &Goals<'p>,
        attempt: usize,
        choices: &mut Vec<ChoicePoint<'p>>,
    ) -> Result<MatchStep<'p>, EvaluationError> {
        match goal {
            Goal::One(pattern, value) => self.one(pattern, value, next, attempt, choices),
            Goal::Sequence(patterns, values) => self.sequence(patterns, values, next, attempt, choices),
        }
    }

    fn one<'p>(
        &mut self,
        pattern: &'p Pattern,
        value: &'p Value,
        next: &Goals<'p>,
        attempt: usize,
        choices: &mut Vec<ChoicePoint<'p>>,
    ) -> Result<MatchStep<'p>, EvaluationError> {
        let holds = match pattern {
            Pattern::Not(inner) => {
                let bound = self.bindings.len();
                let matched = self.solve(Goal::One(inner, value))?;
                self.bindings.truncate(bound);
                !matched
            }
            Pattern::List(patterns) => match value.as_list() {
                Some(values) => return Ok(push(Goal::Sequence(patterns, values), next.clone())),
                None => false,
            },
            Pattern::And(patterns) => {
                let all = patterns.iter().rev().fold(next.clone(), |next, pattern| {
                    Some(Rc::new(GoalStack { goal: Goal::One(pattern, value), next }))
                });
                return Ok(MatchStep::Continue(all));
            }
            Pattern::Or(patterns) => {
                let Some(chosen) = patterns.get(attempt) else { return Ok(MatchStep::Fail) };
                let goal = Goal::One(pattern, value);
                choices.push(ChoicePoint {
                    goal,
                    next: next.clone(),
                    bound: self.bindings.len(),
                    attempt: attempt + 1,
                });
                return Ok(push(Goal::One(chosen, value), next.clone()));
            }
            _ => self.simple(pattern, value)?.unwrap_or(false),
        };
        Ok(if holds { MatchStep::Continue(next.clone()) } else { MatchStep::Fail })
    }

    fn sequence<'p>(
        &mut self,
        patterns: &'p [Pattern],
        values: &'p [Value],
        next: &Goals<'p>,
        attempt: usize,
        choices: &mut Vec<ChoicePoint<'p>>,
    ) -> Result<MatchStep<'p>, EvaluationError> {
        let Some((first, rest)) = patterns.split_first() else {
            return Ok(if values.is_empty() { MatchStep::Continue(next.clone()) } else { MatchStep::Fail });
        };
        match first {
            Pattern::Segment { variable, minimum, maximum } => {
                let least = usize::from(*minimum).max(attempt);
                let most = maximum.map_or(values.len(), usize::from);
                if least > most {
                    return Ok(MatchStep::Fail);
                }
                let (Some(taken), Some(left)) = (values.get(..least), values.get(least..)) else {
                    return Ok(MatchStep::Fail);
                };
                let goal = Goal::Sequence(patterns, values);
                choices.push(ChoicePoint { goal, next: next.clone(), bound: self.bindings.len(), attempt: least + 1 });
                if let Some(variable) = variable
                    && !self.bind(variable, &Value::list(taken.iter().cloned()))
                {
                    return Ok(MatchStep::Fail);
                }
                Ok(push(Goal::Sequence(rest, left), next.clone()))
            }
            Pattern::Guard(expr) => Ok(match self.evaluate(expr)?.is_true() {
                true => push(Goal::Sequence(rest, values), next.clone()),
                false => MatchStep::Fail,
            }),
            pattern => match values.split_first() {
                Some((value, left)) => {
                    let after = Some(Rc::new(GoalStack { goal: Goal::Sequence(rest, left), next: next.clone() }));
                    Ok(push(Goal::One(pattern, value), after))
                }
                None => Ok(MatchStep::Fail),
            },
        }
    }

    fn lookup(&self, name: &Symbol) -> Option<Value> {
        self.bindings.get(name).cloned().or_else(|| self.context.variable(name))
    }

    fn bind(&mut self, name: &Symbol, value: &Value) -> bool {
        match self.lookup(name) {
            Some(bound) => bound.matches(value),
            None => {
                self.bindings.set(name.clone(), value.clone());
                true
            }
        }
    }

    fn evaluate(&self, expr: &Expr) -> Result<Value, EvaluationError> {
        evaluate(expr, &WithBindings { below: self.context, bindings: self.bindings })
    }

    fn holds(&self, predicate: &Symbol, value: &Value) -> Result<bool, EvaluationError> {
        let argument = Expr { kind: ExprKind::Constant(value.clone()), place: self.place };
        let call = ExprKind::Call { function: predicate.clone(), arguments: vec![argument] };
        self.evaluate(&Expr { kind: call, place: self.place }).map(|value| value.is_true())
    }

    fn error(&self, message: String) -> EvaluationError {
        EvaluationError { message, place: self.place }
    }
}

fn push<'p>(goal: Goal<'p>, next: Goals<'p>) -> MatchStep<'p> {
    MatchStep::Continue(Some(Rc::new(GoalStack { goal, next })))
}
