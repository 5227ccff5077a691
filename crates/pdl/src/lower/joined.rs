//! Variables shared by the parts of a condition: later parts may use variables that earlier parts bind.
//!
//! Parts are watched separately, and their results are joined where they agree. So `<?v>` in a later part is equivalent to `?v`, and a
//! comparison with it becomes a constraint on the parts together.

use super::Lowering;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use apex_forms::variables;
use apex_model::condition::{
    Condition, ConditionKind, Constraint, EpisodeCondition, MeasurementCondition, Relation, Timing,
};
use apex_model::expression::{Expr, ExprKind};
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use std::collections::BTreeSet;
use std::sync::Arc;

type Names = BTreeSet<Symbol>;

impl Lowering {
    /// Returns the conditions of a clause, which hold together: joined, and each use of a variable inspected.
    pub(crate) fn clause_conditions(&mut self, mut conditions: Vec<Condition>, clause: Span) -> Vec<Condition> {
        let constraints = join(&mut conditions);
        for condition in &conditions {
            self.report_apart(condition, clause);
        }
        if constraints.is_empty() {
            return conditions;
        }
        vec![Condition { tag: None, kind: ConditionKind::And(conditions, constraints), place: clause.place() }]
    }

    /// Reports variables that one part needs to be judged, and that only another part binds.
    fn report_apart(&mut self, condition: &Condition, clause: Span) {
        let mut leaves = Vec::new();
        each_leaf(condition, &mut |leaf| leaves.push(leaf));
        let mut reported = Names::new();
        for leaf in &leaves {
            let mut own = Names::new();
            bound_by(leaf, &mut own);
            for (name, place) in uses(leaf) {
                let elsewhere = || leaves.iter().any(|other| !std::ptr::eq(*other, *leaf) && binds(other, &name));
                if own.contains(&name) || self.has_value_before(&name, clause) || !elsewhere() {
                    continue;
                }
                if reported.insert(name.clone()) {
                    let message = format!("`?{name}` has no value where this part is judged");
                    let span = self.scope.use_at(&name, place).unwrap_or(clause);
                    let reason = "another part of this condition binds it, and parts are judged before they are joined";
                    let help = format!(
                        "bind what is compared as well, `(ATTRIBUTE OBJECT = ?own)`, and compare both over the whole: \
                         `(:and .. :constraint (> ?own ?{name}))`"
                    );
                    let diagnostic = Diagnostic::error(codes::UNBOUND_VARIABLE, span, message);
                    self.report(diagnostic.reason(reason).help(help));
                }
            }
        }
    }

    /// Returns true if the variable can have a value before the condition of this clause gives it one.
    fn has_value_before(&self, name: &Symbol, clause: Span) -> bool {
        self.scope.tags.contains(name)
            || self.scope.results.contains_key(name)
            || self.scope.first_binder(name).is_none_or(|first| first.file != clause.file || first.start < clause.start)
    }
}

/// Joins the parts of an `:and`, of an order or of a relation: variables that a part binds are known in later parts. Returns the
/// constraints on the parts together.
pub(crate) fn join(parts: &mut [Condition]) -> Vec<Expr> {
    let mut bound = Names::new();
    let mut constraints = Vec::new();
    for part in parts {
        if !bound.is_empty() {
            take_over(part, &bound);
            compare_together(part, &bound, &mut constraints);
        }
        bound_by(part, &mut bound);
    }
    constraints
}

/// Collects the variables that a result of the condition certainly binds.
fn bound_by(condition: &Condition, names: &mut Names) {
    match &condition.kind {
        ConditionKind::Or(parts, _) => {
            let each = parts.iter().map(|part| {
                let mut own = Names::new();
                bound_by(part, &mut own);
                own
            });
            names.extend(each.reduce(|all, own| all.intersection(&own).cloned().collect()).unwrap_or_default());
        }
        ConditionKind::And(parts, _) | ConditionKind::InOrder(parts, _) | ConditionKind::Allen { parts, .. } => {
            parts.iter().for_each(|part| bound_by(part, names));
        }
        ConditionKind::Not(_) | ConditionKind::Absent(..) => {}
        ConditionKind::Probing { condition, .. } => bound_by(condition, names),
        ConditionKind::Measurement(measurement) => {
            of_pattern(&measurement.variable.object, names);
            [&measurement.value, &measurement.object, &measurement.timestamp]
                .into_iter()
                .for_each(|each| of_constraints(each, names));
        }
        ConditionKind::Episode(episode) => {
            of_pattern(&episode.variable.object, names);
            [&episode.value, &episode.first_value, &episode.last_value, &episode.object]
                .into_iter()
                .for_each(|each| of_constraints(each, names));
        }
        ConditionKind::Cyclic(cyclic) => of_pattern(&cyclic.variable.object, names),
        ConditionKind::Event { pattern, .. } => of_pattern(pattern, names),
        ConditionKind::TaskState { state, .. } => of_pattern(state, names),
        ConditionKind::Delay(..)
        | ConditionKind::Timestamp(..)
        | ConditionKind::TaskEnded(_)
        | ConditionKind::Function(_) => {}
    }
}

fn binds(leaf: &Condition, name: &Symbol) -> bool {
    let mut names = Names::new();
    bound_by(leaf, &mut names);
    names.contains(name)
}

fn of_constraints(constraints: &[Constraint], names: &mut Names) {
    for constraint in constraints {
        match constraint {
            Constraint::Matches(pattern) => of_pattern(pattern, names),
            constraint => names.extend(taken(constraint).cloned()),
        }
    }
}

/// Returns the variable that takes the value: `= ?v`.
fn taken(constraint: &Constraint) -> Option<&Symbol> {
    match constraint {
        Constraint::Compare {
            relation: Relation::Equal,
            right: Expr { kind: ExprKind::Variable { name, must_be_bound: false }, .. },
            tolerance: None,
        } => Some(name),
        _ => None,
    }
}

fn of_pattern(pattern: &Pattern, names: &mut Names) {
    match pattern {
        Pattern::Variable(name)
        | Pattern::Is { variable: name, .. }
        | Pattern::Segment { variable: Some(name), .. } => {
            names.insert(name.clone());
        }
        Pattern::List(parts) | Pattern::And(parts) => parts.iter().for_each(|part| of_pattern(part, names)),
        Pattern::Literal(_)
        | Pattern::BoundVariable(_)
        | Pattern::Anonymous
        | Pattern::Computed(_)
        | Pattern::Guard(_)
        | Pattern::Segment { variable: None, .. }
        | Pattern::Or(_)
        | Pattern::Not(_) => {}
    }
}

/// Turns `<?v>` into `?v` where an earlier part binds the variable; the join then requires equal values.
fn take_over(condition: &mut Condition, bound: &Names) {
    match &mut condition.kind {
        ConditionKind::And(parts, _)
        | ConditionKind::Or(parts, _)
        | ConditionKind::InOrder(parts, _)
        | ConditionKind::Allen { parts, .. } => parts.iter_mut().for_each(|part| take_over(part, bound)),
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => take_over(part, bound),
        ConditionKind::Probing { condition, .. } => take_over(condition, bound),
        ConditionKind::Measurement(measurement) => {
            let MeasurementCondition { variable, value, object, .. } = Arc::make_mut(measurement);
            open(&mut variable.object, bound);
            [value, object].into_iter().for_each(|each| open_constraints(each, bound));
        }
        ConditionKind::Episode(episode) => {
            let EpisodeCondition { variable, object, .. } = Arc::make_mut(episode);
            open(&mut variable.object, bound);
            open_constraints(object, bound);
        }
        ConditionKind::Cyclic(cyclic) => open(&mut Arc::make_mut(cyclic).variable.object, bound),
        ConditionKind::Event { pattern, .. } => open(Arc::make_mut(pattern), bound),
        ConditionKind::TaskState { state, .. } => open(state, bound),
        ConditionKind::Delay(..)
        | ConditionKind::Timestamp(..)
        | ConditionKind::TaskEnded(_)
        | ConditionKind::Function(_) => {}
    }
}

fn open(pattern: &mut Pattern, bound: &Names) {
    match pattern {
        Pattern::BoundVariable(name) if bound.contains(name) => *pattern = Pattern::Variable(name.clone()),
        Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => {
            parts.iter_mut().for_each(|part| open(part, bound));
        }
        _ => {}
    }
}

fn open_constraints(constraints: &mut [Constraint], bound: &Names) {
    for constraint in constraints {
        match constraint {
            Constraint::Matches(pattern) => open(pattern, bound),
            Constraint::Compare { relation: Relation::Equal, right, tolerance: None } => match &mut right.kind {
                ExprKind::Variable { name, must_be_bound } if bound.contains(name) => *must_be_bound = false,
                _ => {}
            },
            Constraint::Compare { .. } | Constraint::Predicate(..) | Constraint::Range(..) => {}
        }
    }
}

/// Moves constraints on a sample that use variables of an earlier part to the constraints on the parts together. The sample's value is
/// bound to a variable for them.
fn compare_together(condition: &mut Condition, bound: &Names, constraints: &mut Vec<Expr>) {
    let place = condition.place;
    let ConditionKind::Measurement(measurement) = &mut condition.kind else { return };
    let asks = |constraint: &Constraint| taken(constraint).is_none() && mentions(constraint, bound);
    if measurement.estimation.is_some() || !measurement.value.iter().any(asks) {
        return;
    }
    let measurement = Arc::make_mut(measurement);
    let own = measurement.value.iter().find_map(taken).cloned();
    let name = own.clone().unwrap_or_else(|| {
        let attribute = measurement.variable.attribute.printed();
        Symbol::new(&format!("{attribute}~{}.{}", place.line, place.column))
    });
    let value = Expr { kind: ExprKind::Variable { name, must_be_bound: false }, place };
    let mut kept = Vec::new();
    for constraint in std::mem::take(&mut measurement.value) {
        if !asks(&constraint) {
            kept.push(constraint);
            continue;
        }
        match constraint {
            Constraint::Compare { relation, right, tolerance: None } => {
                constraints.push(call(word(relation), vec![value.clone(), right], place));
            }
            Constraint::Compare { relation, right, tolerance: Some(tolerance) } => {
                let apart = call("abs", vec![call("-", vec![value.clone(), right], place)], place);
                let word = if relation == Relation::Different { ">" } else { "<=" };
                constraints.push(call(word, vec![apart, tolerance], place));
            }
            Constraint::Range(least, most) => {
                let ends = [(least, ">="), (most, "<=")];
                let ends = ends.into_iter().filter_map(|(end, word)| end.map(|end| (end, word)));
                constraints.extend(ends.map(|(end, word)| call(word, vec![value.clone(), end], place)));
            }
            Constraint::Predicate(predicate, arguments) => {
                let arguments = std::iter::once(value.clone()).chain(arguments).collect();
                constraints.push(Expr { kind: ExprKind::Call { function: predicate, arguments }, place });
            }
            Constraint::Matches(_) => kept.push(constraint),
        }
    }
    if own.is_none() {
        kept.push(Constraint::Compare { relation: Relation::Equal, right: value, tolerance: None });
    }
    measurement.value = kept;
}

fn call(function: &str, arguments: Vec<Expr>, place: Place) -> Expr {
    Expr { kind: ExprKind::Call { function: Symbol::new(function), arguments }, place }
}

fn word(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "=",
        Relation::Different => "/=",
        Relation::Less => "<",
        Relation::LessOrEqual => "<=",
        Relation::Greater => ">",
        Relation::GreaterOrEqual => ">=",
    }
}

/// Returns true if the constraint compares with one of these variables. Patterns need no comparison to agree.
fn mentions(constraint: &Constraint, names: &Names) -> bool {
    let mut found = false;
    for expr in right_sides(constraint) {
        variables::of_expr(expr, &mut |name| found |= names.contains(name));
    }
    found
}

fn right_sides(constraint: &Constraint) -> Vec<&Expr> {
    match constraint {
        Constraint::Compare { right, tolerance, .. } => std::iter::once(right).chain(tolerance).collect(),
        Constraint::Range(least, most) => least.iter().chain(most).collect(),
        Constraint::Predicate(_, arguments) => arguments.iter().collect(),
        Constraint::Matches(_) => Vec::new(),
    }
}

fn each_leaf<'a>(condition: &'a Condition, act: &mut dyn FnMut(&'a Condition)) {
    match &condition.kind {
        ConditionKind::And(parts, _)
        | ConditionKind::Or(parts, _)
        | ConditionKind::InOrder(parts, _)
        | ConditionKind::Allen { parts, .. } => parts.iter().for_each(|part| each_leaf(part, act)),
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => each_leaf(part, act),
        ConditionKind::Probing { condition, .. } => each_leaf(condition, act),
        _ => act(condition),
    }
}

/// Returns the variables that must be known to judge a leaf, with their places.
fn uses(leaf: &Condition) -> Vec<(Symbol, Place)> {
    let mut found = Vec::new();
    match &leaf.kind {
        ConditionKind::Measurement(measurement) => {
            bound_marks(&measurement.variable.object, leaf.place, &mut found);
            for constraints in [&measurement.value, &measurement.object, &measurement.timestamp] {
                of_right_sides(constraints, leaf.place, &mut found);
            }
        }
        ConditionKind::Episode(episode) => {
            bound_marks(&episode.variable.object, leaf.place, &mut found);
            let Timing { start, end, duration } = &episode.timing;
            let lists =
                [&episode.value, &episode.first_value, &episode.last_value, &episode.object, start, end, duration];
            lists.into_iter().for_each(|each| of_right_sides(each, leaf.place, &mut found));
            let aggregates = episode.stats.iter().chain(&episode.trend);
            aggregates.for_each(|(_, constraints)| of_right_sides(constraints, leaf.place, &mut found));
        }
        ConditionKind::Event { pattern, timing } => {
            bound_marks(pattern, leaf.place, &mut found);
            let Timing { start, end, duration } = timing.as_ref();
            [start, end, duration].into_iter().for_each(|each| of_right_sides(each, leaf.place, &mut found));
        }
        ConditionKind::Function(expr) => of_expr(expr, &mut found),
        ConditionKind::Delay(first, last) | ConditionKind::Timestamp(first, last) => {
            std::iter::once(first).chain(last).for_each(|each| of_expr(each, &mut found));
        }
        _ => {}
    }
    found
}

fn of_right_sides(constraints: &[Constraint], place: Place, found: &mut Vec<(Symbol, Place)>) {
    for constraint in constraints {
        match constraint {
            Constraint::Matches(pattern) => bound_marks(pattern, place, found),
            constraint if taken(constraint).is_some() => {}
            constraint => right_sides(constraint).into_iter().for_each(|expr| of_expr(expr, found)),
        }
    }
}

fn of_expr(expr: &Expr, found: &mut Vec<(Symbol, Place)>) {
    variables::of_expr(expr, &mut |name| found.push((name.clone(), expr.place)));
}

/// Collects every `<?v>` of a pattern.
fn bound_marks(pattern: &Pattern, place: Place, found: &mut Vec<(Symbol, Place)>) {
    match pattern {
        Pattern::BoundVariable(name) => found.push((name.clone(), place)),
        Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => {
            parts.iter().for_each(|part| bound_marks(part, place, found));
        }
        Pattern::Not(part) => bound_marks(part, place, found),
        _ => {}
    }
}
