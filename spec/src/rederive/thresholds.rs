//! Values of computed thresholds, from numbers, constants, arithmetic, and the goal of the procedure.

use super::world::World;
use apex_forms::variables;
use apex_model::effect::Method;
use apex_model::expression::{Expr, ExprKind};
use apex_model::pattern::Pattern;
use apex_model::procedure::Procedure;
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::value::Value;

/// Maximum depth of definitions that refer to definitions.
const DEPTH_MAX: u32 = 20;

/// Evaluates expressions in clauses of one task.
pub(super) struct Thresholds<'w, 'a> {
    pub(super) world: &'w World<'a>,
    pub(super) task: TaskId,
}

impl Thresholds<'_, '_> {
    /// Returns the number in SI and its dimension; `None` if the record alone does not determine it.
    pub(super) fn number(&self, expr: &Expr) -> Option<(f64, Dimension)> {
        self.at_depth(expr, DEPTH_MAX)
    }

    fn at_depth(&self, expr: &Expr, depth: u32) -> Option<(f64, Dimension)> {
        let depth = depth.checked_sub(1)?;
        match &expr.kind {
            ExprKind::Constant(value) => value.as_number(),
            ExprKind::Named(name) => self.at_depth(self.world.library.constants.get(name)?, depth),
            ExprKind::Variable { name, .. } => self.bound(name)?.as_number(),
            ExprKind::Call { function, arguments } => {
                let parts: Option<Vec<(f64, Dimension)>> =
                    arguments.iter().map(|argument| self.at_depth(argument, depth)).collect();
                arithmetic(function.folded(), &parts?)
            }
            _ => None,
        }
    }

    /// Returns the value that the goal of the clause's procedure gives to the variable; `None` if anything else may set it to another
    /// value.
    fn bound(&self, name: &Symbol) -> Option<Value> {
        let sets =
            |source: &apex_model::source::SourceFile| ["(setq", "(incf"].iter().any(|word| source.text.contains(word));
        if self.world.library.sources.iter().any(sets) {
            return None;
        }
        let parent = self.world.task(self.task).ok()?.parent?;
        let parent = self.world.task(parent).ok()?;
        let Some(Method::Procedure(place)) = &parent.method else { return None };
        let procedure = self.world.library.procedures.iter().find(|each| each.place == *place)?;
        (!is_bound_by_a_step(procedure, name)).then_some(())?;
        let (Pattern::List(parts), Value::List(items)) = (&procedure.index, parent.goal.as_ref()?) else { return None };
        let plain = |part: &Pattern| matches!(part, Pattern::Literal(_) | Pattern::Variable(_) | Pattern::Anonymous);
        (parts.len() == items.len() && parts.iter().all(plain)).then_some(())?;
        let here = |part: &Pattern| matches!(part, Pattern::Variable(variable) if variable == name);
        parts.iter().zip(items.iter()).find(|(part, _)| here(part)).map(|(_, item)| item.clone())
    }
}

fn is_bound_by_a_step(procedure: &Procedure, name: &Symbol) -> bool {
    procedure.steps.iter().any(|step| {
        let mut found = step.select.iter().any(|(selected, _)| selected == name);
        found |= step.forall.as_ref().is_some_and(|forall| forall.0 == *name);
        step.binds.iter().for_each(|pattern| variables::of_pattern(pattern, &mut |bound| found |= bound == name));
        found
    })
}

fn arithmetic(function: &str, parts: &[(f64, Dimension)]) -> Option<(f64, Dimension)> {
    let (first, rest) = parts.split_first()?;
    let same = parts.iter().all(|(_, dimension)| *dimension == first.1);
    let fold = |combine: fn(f64, f64) -> f64| rest.iter().fold(first.0, |sum, (number, _)| combine(sum, *number));
    match function {
        "+" if same => Some((fold(|a, b| a + b), first.1)),
        "-" if same && rest.is_empty() => Some((-first.0, first.1)),
        "-" if same => Some((fold(|a, b| a - b), first.1)),
        "min" if same => Some((fold(f64::min), first.1)),
        "max" if same => Some((fold(f64::max), first.1)),
        "abs" if rest.is_empty() => Some((first.0.abs(), first.1)),
        "*" => Some(rest.iter().fold(*first, |(number, dimension), part| (number * part.0, dimension.times(part.1)))),
        "/" if !rest.is_empty() => {
            Some(rest.iter().fold(*first, |(number, dimension), part| (number / part.0, dimension.over(part.1))))
        }
        _ => None,
    }
}
