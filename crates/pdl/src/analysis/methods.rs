//! Methods that may serve a goal: procedures, primitives and solvers by the first two words of their indexes.

use crate::matching::{
    Second, Specificity, View, may_match, must_match, pattern_head, second_of_goal, second_of_pattern, specificity,
};
use apex_model::expression::Template;
use apex_model::library::Library;
use apex_model::limits::MATCH_STEPS_MAX;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, Step};
use apex_model::symbol::Symbol;
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// A method that serves goals, by its index in the library. The order is that of selection among equally specific ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Method {
    /// A procedure.
    Procedure(usize),
    /// A primitive.
    Primitive(usize),
    /// A solver, asked only if no other method serves.
    Solver(usize),
}

/// Maximum number of methods followed for one goal; with more, the goal may have any result.
const CANDIDATES_MAX: usize = 64;

#[derive(Default)]
struct MethodGroup {
    by_second: BTreeMap<Second, Vec<Method>>,
    open: Vec<Method>,
}

/// All methods of a library.
pub(crate) struct Methods<'l> {
    library: &'l Library,
    by_head: BTreeMap<&'l Symbol, MethodGroup>,
    open: Vec<Method>,
    /// Methods that may serve the goals of steps, by procedure and step; stored because every check needs them.
    of_steps: Vec<Vec<Option<Vec<Method>>>>,
}

impl<'l> Methods<'l> {
    /// Returns the methods of `library`.
    pub(crate) fn new(library: &'l Library) -> Methods<'l> {
        let mut methods = Methods { library, by_head: BTreeMap::new(), open: Vec::new(), of_steps: Vec::new() };
        for (number, procedure) in library.procedures.iter().enumerate() {
            methods.file(&procedure.index, Method::Procedure(number));
        }
        for (number, primitive) in library.primitives.iter().enumerate() {
            methods.file(&primitive.index, Method::Primitive(number));
        }
        for (number, solver) in library.solvers.iter().enumerate() {
            methods.file(&solver.index, Method::Solver(number));
        }
        let of_step = |step: &Step| match &step.activity {
            Activity::Goal(goal) => methods.serving(goal),
            Activity::Terminate { .. } | Activity::BuiltIn(..) => None,
        };
        methods.of_steps = library.procedures.iter().map(|each| each.steps.iter().map(of_step).collect()).collect();
        methods
    }

    fn file(&mut self, index: &'l Pattern, method: Method) {
        let Some(head) = pattern_head(index) else { return self.open.push(method) };
        let group = self.by_head.entry(head).or_default();
        match second_of_pattern(index) {
            Some(second) => group.by_second.entry(second).or_default().push(method),
            None => group.open.push(method),
        }
    }

    /// Returns the index of `method`.
    pub(crate) fn index(&self, method: Method) -> Option<&'l Pattern> {
        let library = self.library;
        match method {
            Method::Procedure(number) => library.procedures.get(number).map(|procedure| &procedure.index),
            Method::Primitive(number) => library.primitives.get(number).map(|primitive| &primitive.index),
            Method::Solver(number) => library.solvers.get(number).map(|solver| &solver.index),
        }
    }

    /// Returns the methods that may serve `goal`, in the order of choice; `None` if that is undecided.
    pub(crate) fn serving(&self, goal: &Template) -> Option<Vec<Method>> {
        let view = View::Template(goal);
        let head = view.head()?;
        let mut found = Vec::new();
        for method in self.filed(head, second_of_goal(view)) {
            let Some(index) = self.index(method) else { continue };
            if may_match(view, index, &mut { MATCH_STEPS_MAX }) {
                if found.len() == CANDIDATES_MAX {
                    return None;
                }
                found.push(method);
            }
        }
        if found.len() > 1 {
            found.sort_by_cached_key(|method| (matches!(method, Method::Solver(_)), self.rank(*method), *method));
        }
        // A method that follows a certain match is never chosen, if every agent knows the matching method.
        let is_sure = |method: &Method| self.is_known_to_all(*method) && self.surely(goal, *method);
        if found.len() > 1
            && let Some(sure) = found.iter().position(is_sure)
        {
            found.truncate(sure + 1);
        }
        Some(found)
    }

    /// Returns the methods that may serve the goal of a step, in the order of choice; `None` if that is undecided.
    pub(crate) fn serving_step(&self, procedure: usize, step: usize) -> Option<&[Method]> {
        self.of_steps.get(procedure)?.get(step)?.as_deref()
    }

    /// Returns a sort key that puts the most specific method first.
    fn rank(&self, method: Method) -> Option<Reverse<Specificity>> {
        self.index(method).map(|index| Reverse(specificity(index)))
    }

    fn is_known_to_all(&self, method: Method) -> bool {
        let bundle = match method {
            Method::Procedure(number) => self.library.procedures.get(number).and_then(|each| each.bundle.as_ref()),
            Method::Primitive(number) => self.library.primitives.get(number).and_then(|each| each.bundle.as_ref()),
            Method::Solver(_) => None,
        };
        let knows = |bundle: &Symbol, bundles: &[Symbol]| bundles.is_empty() || bundles.contains(bundle);
        bundle.is_none_or(|bundle| self.library.agents.iter().all(|agent| knows(bundle, &agent.bundles)))
    }

    fn filed(&self, head: &Symbol, second: Option<Second>) -> impl Iterator<Item = Method> {
        let group = self.by_head.get(head);
        let listed: Vec<&Vec<Method>> = match (group, second) {
            (None, _) => Vec::new(),
            (Some(group), Some(second)) => {
                group.by_second.get(&second).into_iter().chain(std::iter::once(&group.open)).collect()
            }
            (Some(group), None) => group.by_second.values().chain(std::iter::once(&group.open)).collect(),
        };
        listed.into_iter().flatten().chain(&self.open).copied()
    }

    /// Returns true if `method` serves `goal`, whatever values its variables get.
    pub(crate) fn surely(&self, goal: &Template, method: Method) -> bool {
        self.index(method).is_some_and(|index| must_match(View::Template(goal), index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::read_value;
    use apex_model::expression::{Expr, ExprKind};
    use apex_model::source::Place;
    use apex_model::value::Value;

    fn library(indexes: &[&str]) -> Library {
        let text: String = indexes.iter().map(|index| format!("(primitive (index {index}))\n")).collect();
        let source = crate::SourceText { name: "a.pdl".to_string(), text };
        let mut resolve = |_| Err("nothing is required".into());
        crate::check(vec![source], crate::CheckOptions { fragment: false, host: &[], resolve: &mut resolve }).library
    }

    #[test]
    fn methods_are_found_by_two_words_and_by_one() {
        let library = library(&["(go home)", "(go ?where)", "(go home now)", "(go 2)", "(?verb home)"]);
        let methods = Methods::new(&library);
        let hole = |verb: &str| {
            let name = ExprKind::Variable { name: Symbol::new("x"), must_be_bound: false };
            let expr = Expr { kind: name, place: Place::default() };
            Template::List(vec![Template::Constant(Value::symbol(verb)), Template::Hole(expr)])
        };
        let serving = |goal: &str| {
            let goal = Template::Constant(read_value(goal).expect("a value"));
            let found = methods.serving(&goal).expect("a head");
            found.into_iter().map(|method| matches!(method, Method::Primitive(number) if number < 9)).count()
        };
        // The constant index is chosen; no other method is considered.
        assert_eq!(serving("(go home)"), 1);
        assert_eq!(serving("(go 2.0)"), 1);
        assert_eq!(serving("(go away)"), 1);
        assert_eq!(methods.serving(&hole("go")).map(|found| found.len()), Some(3));
        assert_eq!(serving("(stay home)"), 1);
        assert_eq!(serving("(stay away)"), 0);
    }
}
