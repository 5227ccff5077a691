//! Pattern matching (M&I)
//! What: matches a value against a pattern with variables, segments and guards.
//! Runs: on messages and samples, at procedure selection.
//! Reads: surroundings.
//! Writes: bindings.
//! Bound: `MATCH_STEPS_MAX` steps; without segments linear in the pattern.
//! PDL: section 2.
//! Paper: section III, pattern matching.

use crate::expression::{EvaluationError, Surroundings, WithBindings, evaluate};
use apex_model::bindings::Bindings;
use apex_model::expression::{Expr, ExprKind};
use apex_model::limits::MATCH_STEPS_MAX;
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::rc::Rc;

/// Does `value` match `pattern`? Variables already bound, in `bindings` or in `surroundings`, must match what they
/// are bound to; others are added to `bindings`. Without a match, or on an error, `bindings` is as before. Segments
/// take as few elements as possible; `place` is where messages point that have no place of their own.
///
/// # Errors
/// When a computed part, guard or predicate fails, a `<?x>` is unbound, or the match takes too many steps.
pub(crate) fn match_pattern(
    pattern: &Pattern,
    value: &Value,
    bindings: &mut Bindings,
    surroundings: &dyn Surroundings,
    place: Place,
) -> Result<bool, EvaluationError> {
    let mut steps = 0;
    let length = bindings.len();
    let straight = is_straight(pattern);
    let mut matcher = Matcher { bindings, surroundings, place, steps: &mut steps };
    let result = if straight { matcher.straight(pattern, value) } else { matcher.solve(Goal::One(pattern, value)) };
    if !matches!(result, Ok(true)) {
        bindings.truncate(length);
    }
    result
}

/// Is there one way only to match it, without a choice to take back? Most patterns are so.
fn is_straight(pattern: &Pattern) -> bool {
    match pattern {
        Pattern::Literal(_) | Pattern::Variable(_) | Pattern::BoundVariable(_) | Pattern::Anonymous => true,
        Pattern::Computed(_) | Pattern::Is { .. } => true,
        Pattern::List(parts) => parts.iter().all(is_straight),
        Pattern::Guard(_) | Pattern::Segment { .. } | Pattern::And(_) | Pattern::Or(_) | Pattern::Not(_) => false,
    }
}

/// What remains to be matched.
#[derive(Clone, Copy)]
enum Goal<'a> {
    One(&'a Pattern, &'a Value),
    Sequence(&'a [Pattern], &'a [Value]),
}

/// A goal and those after it. As long as the pattern is deep, never as long as a list.
struct Node<'a> {
    goal: Goal<'a>,
    next: Goals<'a>,
}

type Goals<'a> = Option<Rc<Node<'a>>>;

/// What to try when the present way fails.
struct Choice<'a> {
    goal: Goal<'a>,
    next: Goals<'a>,
    bound: usize,
    /// For a segment at the head of the goal: how many elements to take. For `(?or ..)`: which alternative.
    attempt: usize,
}

struct Matcher<'a> {
    bindings: &'a mut Bindings,
    surroundings: &'a dyn Surroundings,
    place: Place,
    steps: &'a mut u64,
}

/// Where one step leads.
enum Progress<'a> {
    Fail,
    Continue(Goals<'a>),
}

impl Matcher<'_> {
    /// Matches a straight pattern, part by part. As deep as the pattern, which the reader bounds.
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

    /// The outcome of a pattern that has no parts; none for others.
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
        let mut goals: Goals<'p> = Some(Rc::new(Node { goal, next: None }));
        let mut choices: Vec<Choice<'p>> = Vec::new();
        loop {
            let Some(node) = goals else { return Ok(true) };
            // Without a choice the way is straight, and as long as the pattern only.
            *self.steps += u64::from(!choices.is_empty());
            if *self.steps > MATCH_STEPS_MAX {
                return Err(self.error(format!("the match takes more than MATCH_STEPS_MAX = {MATCH_STEPS_MAX} steps")));
            }
            let mut progress = self.advance(node.goal, &node.next, 0, &mut choices)?;
            while let Progress::Fail = progress {
                let Some(choice) = choices.pop() else { return Ok(false) };
                *self.steps += 1;
                self.bindings.truncate(choice.bound);
                progress = self.advance(choice.goal, &choice.next, choice.attempt, &mut choices)?;
            }
            let Progress::Continue(next) = progress else { return Ok(false) };
            goals = next;
        }
    }

    fn advance<'p>(
        &mut self,
        goal: Goal<'p>,
        next: &Goals<'p>,
        attempt: usize,
        choices: &mut Vec<Choice<'p>>,
    ) -> Result<Progress<'p>, EvaluationError> {
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
        choices: &mut Vec<Choice<'p>>,
    ) -> Result<Progress<'p>, EvaluationError> {
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
                let all = patterns
                    .iter()
                    .rev()
                    .fold(next.clone(), |next, pattern| Some(Rc::new(Node { goal: Goal::One(pattern, value), next })));
                return Ok(Progress::Continue(all));
            }
            Pattern::Or(patterns) => {
                let Some(chosen) = patterns.get(attempt) else { return Ok(Progress::Fail) };
                let goal = Goal::One(pattern, value);
                choices.push(Choice { goal, next: next.clone(), bound: self.bindings.len(), attempt: attempt + 1 });
                return Ok(push(Goal::One(chosen, value), next.clone()));
            }
            _ => self.simple(pattern, value)?.unwrap_or(false),
        };
        Ok(if holds { Progress::Continue(next.clone()) } else { Progress::Fail })
    }

    fn sequence<'p>(
        &mut self,
        patterns: &'p [Pattern],
        values: &'p [Value],
        next: &Goals<'p>,
        attempt: usize,
        choices: &mut Vec<Choice<'p>>,
    ) -> Result<Progress<'p>, EvaluationError> {
        let Some((first, rest)) = patterns.split_first() else {
            return Ok(if values.is_empty() { Progress::Continue(next.clone()) } else { Progress::Fail });
        };
        match first {
            Pattern::Segment { variable, minimum, maximum } => {
                let least = usize::from(*minimum).max(attempt);
                let most = maximum.map_or(values.len(), usize::from);
                if least > most {
                    return Ok(Progress::Fail);
                }
                let (Some(taken), Some(left)) = (values.get(..least), values.get(least..)) else {
                    return Ok(Progress::Fail);
                };
                let goal = Goal::Sequence(patterns, values);
                choices.push(Choice { goal, next: next.clone(), bound: self.bindings.len(), attempt: least + 1 });
                if let Some(variable) = variable
                    && !self.bind(variable, &Value::list(taken.iter().cloned()))
                {
                    return Ok(Progress::Fail);
                }
                Ok(push(Goal::Sequence(rest, left), next.clone()))
            }
            Pattern::Guard(expr) => Ok(match self.evaluate(expr)?.is_true() {
                true => push(Goal::Sequence(rest, values), next.clone()),
                false => Progress::Fail,
            }),
            pattern => match values.split_first() {
                Some((value, left)) => {
                    let after = Some(Rc::new(Node { goal: Goal::Sequence(rest, left), next: next.clone() }));
                    Ok(push(Goal::One(pattern, value), after))
                }
                None => Ok(Progress::Fail),
            },
        }
    }

    fn lookup(&self, name: &Symbol) -> Option<Value> {
        self.bindings.get(name).cloned().or_else(|| self.surroundings.variable(name))
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
        evaluate(expr, &WithBindings { below: self.surroundings, bindings: self.bindings })
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

fn push<'p>(goal: Goal<'p>, next: Goals<'p>) -> Progress<'p> {
    Progress::Continue(Some(Rc::new(Node { goal, next })))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::View;
    use proptest::prelude::*;

    fn variable(name: &str) -> Pattern {
        Pattern::Variable(Symbol::new(name))
    }

    fn literal(name: &str) -> Pattern {
        Pattern::Literal(Value::symbol(name))
    }

    fn segment(name: &str, minimum: u8, maximum: Option<u8>) -> Pattern {
        Pattern::Segment { variable: Some(Symbol::new(name)), minimum, maximum }
    }

    /// All matches in order, by plain recursion over lists of bindings: the definition.
    fn naive(pattern: &Pattern, value: &Value, bindings: &Bindings) -> Vec<Bindings> {
        match pattern {
            Pattern::Literal(literal) if literal.matches(value) => vec![bindings.clone()],
            Pattern::Anonymous => vec![bindings.clone()],
            Pattern::Variable(name) => naive_bind(name, value, bindings),
            Pattern::Is { variable, predicate } => {
                let number = matches!(value, Value::Integer(_));
                assert!(predicate.is("integerp"));
                if number { naive_bind(variable, value, bindings) } else { Vec::new() }
            }
            Pattern::And(parts) => parts.iter().fold(vec![bindings.clone()], |found, part| {
                found.iter().flat_map(|bindings| naive(part, value, bindings)).collect()
            }),
            Pattern::Or(parts) => parts.iter().flat_map(|part| naive(part, value, bindings)).collect(),
            Pattern::Not(part) if naive(part, value, bindings).is_empty() => vec![bindings.clone()],
            Pattern::List(parts) => match value.as_list() {
                Some(values) => naive_list(parts, values, bindings),
                None => Vec::new(),
            },
            _ => Vec::new(),
        }
    }

    fn naive_bind(name: &Symbol, value: &Value, bindings: &Bindings) -> Vec<Bindings> {
        match bindings.get(name) {
            Some(bound) if bound.matches(value) => vec![bindings.clone()],
            Some(_) => Vec::new(),
            None => {
                let mut extended = bindings.clone();
                extended.set(name.clone(), value.clone());
                vec![extended]
            }
        }
    }

    fn naive_list(parts: &[Pattern], values: &[Value], bindings: &Bindings) -> Vec<Bindings> {
        let Some((first, rest)) = parts.split_first() else {
            return if values.is_empty() { vec![bindings.clone()] } else { Vec::new() };
        };
        if let Pattern::Segment { variable, minimum, maximum } = first {
            let most = maximum.map_or(values.len(), usize::from).min(values.len());
            return (usize::from(*minimum)..=most)
                .flat_map(|count| {
                    let taken = Value::list(values[..count].iter().cloned());
                    let bound = match variable {
                        Some(name) => naive_bind(name, &taken, bindings),
                        None => vec![bindings.clone()],
                    };
                    bound.into_iter().flat_map(move |bindings| naive_list(rest, &values[count..], &bindings))
                })
                .collect();
        }
        let Some((value, left)) = values.split_first() else { return Vec::new() };
        naive(first, value, bindings).iter().flat_map(|bindings| naive_list(rest, left, bindings)).collect()
    }

    fn values() -> impl Strategy<Value = Value> {
        let leaf = prop_oneof![
            (0..3_i64).prop_map(Value::Integer),
            (0..3_i64).prop_map(|n| Value::Real(n as f64)),
            prop_oneof![Just("a"), Just("B")].prop_map(Value::symbol),
            prop_oneof![Just("Up"), Just("UP")].prop_map(Value::text),
        ];
        leaf.prop_recursive(3, 24, 5, |inner| proptest::collection::vec(inner, 0..5).prop_map(Value::list))
    }

    fn patterns() -> impl Strategy<Value = Pattern> {
        let name = || prop_oneof![Just("x"), Just("y")].prop_map(Symbol::new);
        let leaf = prop_oneof![
            values().prop_map(Pattern::Literal),
            name().prop_map(Pattern::Variable),
            Just(Pattern::Anonymous),
            name().prop_map(|variable| Pattern::Is { variable, predicate: Symbol::new("integerp") }),
        ];
        let segment = (proptest::option::of(name()), prop_oneof![Just((0, None)), Just((1, None)), Just((0, Some(1)))])
            .prop_map(|(variable, (minimum, maximum))| Pattern::Segment { variable, minimum, maximum });
        leaf.prop_recursive(3, 24, 4, move |inner| {
            let several = proptest::collection::vec(inner.clone(), 1..4);
            prop_oneof![
                4 => proptest::collection::vec(prop_oneof![3 => inner.clone(), 1 => segment.clone()], 0..4).prop_map(Pattern::List),
                1 => several.clone().prop_map(Pattern::And),
                1 => several.prop_map(Pattern::Or),
                1 => inner.prop_map(|part| Pattern::Not(Box::new(part))),
            ]
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]
        #[test]
        fn agrees_with_the_naive_matcher(pattern in patterns(), value in values()) {
            let expected = naive(&pattern, &value, &Bindings::new()).into_iter().next();
            let mut bindings = Bindings::new();
            let matched = match_pattern(&pattern, &value, &mut bindings, &View::default(), Place::default()).unwrap();
            prop_assert_eq!(matched.then(|| bindings.clone()), expected);
            prop_assert!(matched || bindings.is_empty());
        }
    }

    #[test]
    fn a_choice_inside_a_nested_list_is_taken_back_when_something_after_it_fails() {
        let pattern =
            Pattern::List(vec![Pattern::List(vec![segment("x", 0, None), segment("y", 0, None)]), variable("x")]);
        let inner = Value::list([Value::Integer(1), Value::Integer(2)]);
        let value = Value::list([inner, Value::list([Value::Integer(1)])]);
        let mut bindings = Bindings::new();
        assert!(match_pattern(&pattern, &value, &mut bindings, &View::default(), Place::default()).unwrap());
        assert_eq!(bindings.get(&Symbol::new("y")), Some(&Value::list([Value::Integer(2)])));
    }

    #[test]
    fn hopeless_backtracking_ends_with_a_reason() {
        let parts = (0..8).map(|index| segment(&format!("s{index}"), 0, None)).chain([literal("never")]).collect();
        let value = Value::list((0..40).map(Value::Integer));
        let result =
            match_pattern(&Pattern::List(parts), &value, &mut Bindings::new(), &View::default(), Place::default());
        assert!(result.unwrap_err().message.contains("MATCH_STEPS_MAX"));
    }

    #[test]
    fn long_lists_without_segments_stay_within_the_limit() {
        let parts = (0..40_000).map(|index| Pattern::Literal(Value::Integer(index))).collect();
        let value = Value::list((0..40_000).map(|index| Value::Real(index as f64)));
        assert!(
            match_pattern(&Pattern::List(parts), &value, &mut Bindings::new(), &View::default(), Place::default())
                .unwrap()
        );
    }

    #[test]
    fn variables_bound_before_must_match() {
        let view = View {
            variables: {
                let mut b = Bindings::new();
                b.set(Symbol::new("x"), Value::text("UP"));
                b
            },
            ..View::default()
        };
        let mut bindings = Bindings::new();
        let mut matched =
            |pattern: &Pattern, value: Value| match_pattern(pattern, &value, &mut bindings, &view, Place::default());
        assert!(matched(&variable("x"), Value::text("up")).unwrap());
        assert!(!matched(&variable("x"), Value::text("down")).unwrap());
        assert!(
            matched(&Pattern::BoundVariable(Symbol::new("y")), Value::Integer(1)).unwrap_err().message.contains("<?y>")
        );
    }
}
