//! The planners of a program: the shipped ones, and those that third parties add.

use crate::solver::Solver;
use apex_model::problem::Problem;
use std::sync::Arc;

/// Planners by name, in the order of their complexity, added ones last.
#[derive(Clone, Default)]
pub struct Registry {
    solvers: Vec<Arc<dyn Solver>>,
}

impl Registry {
    /// Returns a registry of `solvers`, whose names must be valid and distinct ([`Registry::add`]).
    pub fn of(solvers: Vec<Arc<dyn Solver>>) -> Registry {
        Registry { solvers }
    }

    /// Adds a planner.
    ///
    /// # Errors
    /// An error message if its name is taken, or could not occur in `(solver NAME ..)`.
    pub fn add(&mut self, solver: Arc<dyn Solver>) -> Result<(), String> {
        let name = solver.name();
        let word = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '-';
        if !name.starts_with(|letter: char| letter.is_ascii_lowercase()) || !name.chars().all(word) || name == "auto" {
            return Err(format!(
                "`{name}` cannot be the name of a planner: write lower-case letters, digits and hyphens, a letter first; `auto` means that one is chosen"
            ));
        }
        if self.find(name).is_some() {
            return Err(format!("there is a planner called `{name}` already; choose another name"));
        }
        self.solvers.push(solver);
        Ok(())
    }

    /// Returns the planner called `name`.
    pub fn find(&self, name: &str) -> Option<&Arc<dyn Solver>> {
        self.solvers.iter().find(|solver| solver.name() == name)
    }

    /// Returns all planners.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<dyn Solver>> {
        self.solvers.iter()
    }

    /// Returns the planners that serve problems like `problem`.
    pub fn serving(&self, problem: &Problem) -> Vec<Arc<dyn Solver>> {
        self.iter().filter(|solver| solver.serves(problem)).cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::Environment;
    use apex_model::problem::Plan;

    struct Named(&'static str);

    impl Solver for Named {
        fn name(&self) -> &str {
            self.0
        }
        fn serves(&self, _: &Problem) -> bool {
            true
        }
        fn solve(&self, _: &Problem, _: &mut Environment<'_>) -> Result<Plan, String> {
            Err("no idea".into())
        }
    }

    #[test]
    fn planners_are_added_under_names_of_their_own() {
        let mut registry = Registry::default();
        registry.add(Arc::new(Named("wam"))).unwrap();
        registry.add(Arc::new(Named("mine-2"))).unwrap();
        assert!(registry.find("mine-2").is_some() && registry.iter().count() == 2);
        assert!(registry.add(Arc::new(Named("wam"))).unwrap_err().contains("called `wam` already"));
        for name in ["", "auto", "My", "2", "a b", "é"] {
            assert!(registry.add(Arc::new(Named(name))).unwrap_err().contains("cannot be the name"), "{name}");
        }
    }
}
