//! A linear program whose columns lie between zero and an upper bound, and the value that multipliers of its rows prove.
//!
//! `clarabel` (an interior-point solver) finds the multipliers. The proven value is computed here from the rows alone and holds for any
//! multipliers: weak duality with bounded columns (Neumaier and Shcherbina 2004).

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// Relative amount, of all terms, by which a proven value is lowered, so that rounding cannot lift it above the true value.
const ROUNDING: f64 = 1e-12;
/// Maximum number of steps of the solver.
pub(super) const STEPS_MAX: u32 = 100;
/// Work of a step in nanoseconds for each entry of the matrix: a constant part, and a factor of the root of the number of entries, because
/// the factors of the matrix fill in. Measured per step: 0.15 ms at 1,100 entries, 5 ms at 20,000, 38 ms at 75,000, 430 ms at 397,000; the
/// formula is within a sixth of all.
const ENTRY_NS: f64 = 80.0;
const ENTRY_FILLED_NS: f64 = 1.4;

/// A linear program: minimises the cost of the columns subject to the rows.
#[derive(Clone, Debug, Default)]
pub(super) struct LinearProgram {
    columns: Vec<Column>,
    equal: Vec<ProgramRow>,
    at_most: Vec<ProgramRow>,
}

#[derive(Clone, Copy, Debug)]
struct Column {
    cost: f64,
    most: f64,
}

#[derive(Clone, Debug)]
struct ProgramRow {
    terms: Vec<(usize, f64)>,
    limit: f64,
}

/// Columns of the least cost, and the multipliers of the rows, those of equations first.
pub(super) struct DualSolution {
    /// Steps that were taken.
    pub(super) steps: u32,
    pub(super) columns: Vec<f64>,
    pub(super) multipliers: Vec<f64>,
}

impl LinearProgram {
    /// Adds a column with a cost per unit, and an upper bound that no represented plan exceeds.
    pub(super) fn column(&mut self, cost: f64, most: f64) -> usize {
        self.columns.push(Column { cost, most });
        self.columns.len() - 1
    }

    /// Adds a row: the terms sum to `limit`. A row contains each column at most once.
    pub(super) fn equal(&mut self, terms: Vec<(usize, f64)>, limit: f64) {
        self.equal.push(ProgramRow { terms, limit });
    }

    /// Adds a row: the terms sum to at most `limit`. A row contains each column at most once.
    pub(super) fn at_most(&mut self, terms: Vec<(usize, f64)>, limit: f64) {
        self.at_most.push(ProgramRow { terms, limit });
    }

    fn rows(&self) -> impl Iterator<Item = &ProgramRow> {
        self.equal.iter().chain(&self.at_most)
    }

    /// Returns the number of entries of the matrix.
    pub(super) fn entries(&self) -> f64 {
        (self.rows().map(|row| row.terms.len()).sum::<usize>() + self.columns.len()) as f64
    }

    /// Returns the work of a step of the solver, in nanoseconds.
    pub(super) fn step_ns(&self) -> f64 {
        let entries = self.entries();
        entries * (ENTRY_NS + ENTRY_FILLED_NS * libm::sqrt(entries))
    }

    /// Returns the best columns and multipliers after at most `steps_max` steps; `None` if the solver fails.
    pub(super) fn solve(&self, steps_max: u32) -> Option<DualSolution> {
        let (count, rows) = (self.columns.len(), self.equal.len() + self.at_most.len());
        let mut by_column: Vec<Vec<(usize, f64)>> = vec![Vec::new(); count];
        for (number, row) in self.rows().enumerate() {
            for (column, factor) in &row.terms {
                by_column.get_mut(*column)?.push((number, *factor));
            }
        }
        let (mut starts, mut numbers, mut factors) = (vec![0], Vec::new(), Vec::new());
        for (column, entries) in by_column.iter().enumerate() {
            // No column is negative: a row for each column follows the other rows.
            for (number, factor) in entries.iter().copied().chain([(rows + column, -1.0)]) {
                numbers.push(number);
                factors.push(factor);
            }
            starts.push(numbers.len());
        }
        let matrix = CscMatrix::new(rows + count, count, starts, numbers, factors);
        let limits: Vec<f64> = self.rows().map(|row| row.limit).chain((0..count).map(|_| 0.0)).collect();
        let costs: Vec<f64> = self.columns.iter().map(|column| column.cost).collect();
        let cones =
            [SupportedConeT::ZeroConeT(self.equal.len()), SupportedConeT::NonnegativeConeT(self.at_most.len() + count)];
        let settings = DefaultSettings { verbose: false, max_iter: steps_max, ..DefaultSettings::default() };
        let flat = CscMatrix::zeros((count, count));
        let mut solver = DefaultSolver::new(&flat, &costs, &matrix, &limits, &cones, settings).ok()?;
        solver.solve();
        let found = &solver.solution;
        let usable = !matches!(found.status, SolverStatus::Unsolved | SolverStatus::PrimalInfeasible);
        let finite = found.x.iter().chain(&found.z).all(|number| number.is_finite());
        let multipliers = found.z.iter().copied().take(rows).collect();
        (usable && finite).then(|| DualSolution { steps: found.iterations, columns: found.x.clone(), multipliers })
    }

    #[cfg(test)]
    pub(super) fn width(&self) -> usize {
        self.columns.len()
    }

    /// Returns the greatest amount by which these columns violate a row or their bounds.
    #[cfg(test)]
    pub(super) fn worst_break(&self, columns: &[f64]) -> f64 {
        let sum = |row: &ProgramRow| {
            row.terms.iter().map(|(column, factor)| factor * columns[*column]).sum::<f64>() - row.limit
        };
        let rows = self.equal.iter().map(|row| sum(row).abs()).chain(self.at_most.iter().map(sum));
        let bounds = self.columns.iter().zip(columns).map(|(column, value)| (value - column.most).max(-value));
        rows.chain(bounds).fold(0.0, f64::max)
    }

    /// Returns a lower bound on the value of all columns that satisfy their bounds and the rows.
    pub(super) fn proven(&self, multipliers: &[f64]) -> f64 {
        let mut reduced: Vec<f64> = self.columns.iter().map(|column| column.cost).collect();
        let (mut value, mut size) = (0.0, 0.0);
        for (number, row) in self.rows().enumerate() {
            let given = multipliers.get(number).copied().filter(|number| number.is_finite()).unwrap_or(0.0);
            let multiplier = if number < self.equal.len() { given } else { given.max(0.0) };
            value -= multiplier * row.limit;
            size += (multiplier * row.limit).abs();
            for (column, factor) in &row.terms {
                if let Some(reduced) = reduced.get_mut(*column) {
                    *reduced += multiplier * factor;
                }
                let most = self.columns.get(*column).map_or(0.0, |column| column.most);
                size += (multiplier * factor * most).abs();
            }
        }
        for (column, reduced) in self.columns.iter().zip(&reduced) {
            value += reduced.min(0.0) * column.most;
        }
        value - ROUNDING * size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the least `x + 2 y` with `x + y = 3`, `x <= 2`.
    fn small() -> LinearProgram {
        let mut program = LinearProgram::default();
        let (x, y) = (program.column(1.0, 10.0), program.column(2.0, 10.0));
        program.equal(vec![(x, 1.0), (y, 1.0)], 3.0);
        program.at_most(vec![(x, 1.0)], 2.0);
        program
    }

    #[test]
    fn the_solver_finds_the_least_and_its_multipliers_prove_it() {
        let program = small();
        let answer = program.solve(STEPS_MAX).unwrap();
        assert!((answer.columns[0] - 2.0).abs() < 1e-6, "{:?}", answer.columns);
        let proven = program.proven(&answer.multipliers);
        assert!((proven - 4.0).abs() < 1e-5 && proven <= 4.0 + 1e-12, "{proven}");
    }

    #[test]
    fn any_multipliers_prove_something_true() {
        for (one, other) in [(0.0, 0.0), (-2.0, 1.0), (5.0, -3.0), (f64::NAN, 1e9), (-100.0, 100.0)] {
            assert!(small().proven(&[one, other]) <= 4.0 + 1e-12);
        }
        assert!(small().proven(&[]) <= 4.0);
    }
}
