//! A checked model: components, failure modes, tests, and the failure condition of each test.

use crate::bits::Bits;
use crate::formula::Formula;

/// A dependency model that has been checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Its name.
    pub name: String,
    /// Components in the order of the file.
    pub components: Vec<Component>,
    /// Failure modes of all components in the order of the file; tests and diagnoses refer to them by index.
    pub modes: Vec<FailureMode>,
    /// Tests in the order of the file; diagnoses refer to them by index.
    pub tests: Vec<Test>,
    /// Names of signals that no test depends on, and that therefore contribute nothing.
    pub unused_signals: Vec<String>,
}

/// A part that can fail as a whole and is replaced or avoided as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Its name, a symbol of PDL.
    pub name: String,
    /// Title for reports; the name if the file states no title.
    pub title: String,
    /// Its failure modes by index.
    pub modes: Vec<usize>,
    /// The goal of PDL that responds to its failure.
    pub response: Option<String>,
}

/// One way in which a component fails.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureMode {
    /// The mode's name: `component/mode` if the file lists modes, otherwise the component's name.
    pub name: String,
    /// Title for reports.
    pub title: String,
    /// The component by index.
    pub component: usize,
    /// Probability of failing in an hour of flight, above 0 and below 0.5.
    pub probability_per_hour: f64,
    /// True if the failure is intermittent, so that a passed test does not exclude it.
    pub is_intermittent: bool,
}

/// A test, and the failures that make it fail.
#[derive(Clone, Debug, PartialEq)]
pub struct Test {
    /// Its name, a symbol of PDL.
    pub name: String,
    /// Title for reports.
    pub title: String,
    /// PDL condition that holds while the test fails; `None` if its outcome is supplied from outside.
    pub monitor: Option<Monitor>,
    pub(crate) formula: Formula,
}

/// A test by conditions of PDL.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Monitor {
    /// Condition under which the test has failed.
    pub fails: String,
    /// Condition under which the test has passed.
    pub passes: String,
}

impl Test {
    /// Returns the minimal sets of failure modes that together make the test fail.
    pub fn implicants(&self) -> &[Bits] {
        &self.formula.implicants
    }

    /// Returns the minimal sets of failure modes that each have a present mode when the test fails.
    pub fn clauses(&self) -> &[Bits] {
        &self.formula.clauses
    }

    /// Returns true if these failure modes make the test fail.
    pub fn fails_with(&self, present: &Bits) -> bool {
        self.formula.implicants.iter().any(|implicant| implicant.is_subset(present))
    }
}

impl Model {
    /// Returns the D-matrix by failure modes: for each mode the tests that fail because of it alone.
    pub fn rows(&self) -> Vec<Bits> {
        let mut rows = vec![Bits::new(self.tests.len()); self.modes.len()];
        for (test, column) in self.columns().iter().enumerate() {
            for mode in column.iter() {
                if let Some(row) = rows.get_mut(mode) {
                    row.insert(test);
                }
            }
        }
        rows
    }

    /// Returns the D-matrix by tests: for each test the failure modes that alone make it fail.
    pub fn columns(&self) -> Vec<Bits> {
        let alone = |test: &Test| {
            let single = test.implicants().iter().filter(|implicant| implicant.len() == 1);
            Bits::of(self.modes.len(), single.filter_map(Bits::first))
        };
        self.tests.iter().map(alone).collect()
    }

    /// Returns the index of the test with this name.
    pub fn test(&self, name: &str) -> Option<usize> {
        self.tests.iter().position(|test| test.name == name)
    }

    /// Returns the index of the component with this name.
    pub fn component(&self, name: &str) -> Option<usize> {
        self.components.iter().position(|component| component.name == name)
    }

    /// Returns the name of a failure mode; empty for an index beyond the last.
    pub fn mode_name(&self, mode: usize) -> &str {
        self.modes.get(mode).map_or("", |mode| mode.name.as_str())
    }

    /// Returns the name of a test; empty for an index beyond the last.
    pub fn test_name(&self, test: usize) -> &str {
        self.tests.get(test).map_or("", |test| test.name.as_str())
    }

    /// Returns the cost of a failure mode in a candidate: the negative logarithm of its prior odds.
    pub fn cost(&self, mode: usize) -> f64 {
        let probability = self.modes.get(mode).map_or(0.5, |mode| mode.probability_per_hour);
        libm::log1p(-probability) - libm::log(probability)
    }
}
