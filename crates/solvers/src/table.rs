//! The profile table and solver selection (paper, section V.C): from features of a problem to the best planner, with the
//! reason in words.
//!
//! The table is data: `data/profile.csv`. Rows are read from the top; the first whose limits all hold is taken.
//! Bound: O(rows) after classification.

use crate::features::{self, Features, Space};
use apex_model::problem::Problem;

/// The table that ships with the product.
pub const PROFILE: &str = include_str!("../data/profile.csv");
/// Work of a second of deliberation, by which budgets in time become budgets in units.
pub const WORK_UNITS_PER_SECOND: u64 = 10_000_000;
/// Work assumed where nobody says how long deliberation may take: one second.
pub const BUDGET_UNITS_DEFAULT: u64 = WORK_UNITS_PER_SECOND;

/// The chosen planner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    /// Its name.
    pub solver: String,
    /// Why: the features and the row of the table.
    pub reason: String,
}

/// One row: limits on features, and the planner that was best within them.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    kind: String,
    space: Option<Space>,
    count_max: f64,
    tour_share_min: f64,
    variation_max: f64,
    budget_units_min: f64,
    solver: String,
    because: String,
}

/// Chooses a planner for `problem` with a second of deliberation.
pub fn select(problem: &Problem) -> Selection {
    select_within(problem, BUDGET_UNITS_DEFAULT)
}

/// Chooses a planner for `problem` with `budget_units` of work.
pub fn select_within(problem: &Problem, budget_units: u64) -> Selection {
    let (kind, features) = match problem {
        Problem::Surveillance(problem) => ("surveillance", features::surveillance(problem)),
        Problem::SingleVisit(problem) => ("single-visit", Ok(features::single_visit(problem))),
    };
    let features = match features {
        Ok(features) => features,
        Err(trouble) => return fallback(problem, &format!("the problem cannot be classified: {trouble}")),
    };
    let rows = match rows(PROFILE) {
        Ok(rows) => rows,
        Err(trouble) => return fallback(problem, &trouble),
    };
    match rows.iter().find(|row| row.kind == kind && row.holds(&features, budget_units)) {
        Some(row) => {
            Selection { solver: row.solver.clone(), reason: format!("{}: {}", described(&features), row.because) }
        }
        None => fallback(problem, &format!("{}: no row of the profile table fits", described(&features))),
    }
}

/// The first planner that serves the problem.
fn fallback(problem: &Problem, reason: &str) -> Selection {
    let serves = crate::solvers().into_iter().find(|solver| solver.serves(problem));
    let solver = serves.map_or_else(|| "none".to_string(), |solver| solver.name().to_string());
    Selection { solver, reason: reason.to_string() }
}

fn described(features: &Features) -> String {
    format!(
        "{} targets {}, {:.1} km across; importance varies by {:.0} %, cost rates by {:.0} %; one tour takes {:.0} % of the time",
        features.count,
        features.space,
        features.extent_m / 1000.0,
        100.0 * features.importance_variation,
        100.0 * features.rate_variation,
        100.0 * features.tour_share
    )
}

impl Row {
    fn holds(&self, features: &Features, budget_units: u64) -> bool {
        self.space.is_none_or(|space| space == features.space)
            && features.count as f64 <= self.count_max
            && features.tour_share >= self.tour_share_min
            && features.importance_variation.max(features.rate_variation) <= self.variation_max
            && budget_units as f64 >= self.budget_units_min
    }
}

/// Reads a table. Lines that begin with `#` are comments; the first other line is the heading; `-` is no limit.
fn rows(text: &str) -> Result<Vec<Row>, String> {
    let lines = text.lines().enumerate().filter(|(_, line)| !line.starts_with('#') && !line.trim().is_empty());
    lines.skip(1).map(|(number, line)| row(line).map_err(|why| format!("profile.csv:{}: {why}", number + 1))).collect()
}

fn row(line: &str) -> Result<Row, String> {
    let fields: Vec<&str> = line.splitn(8, ',').map(str::trim).collect();
    let [kind, space, count_max, tour_share_min, variation_max, budget_units_min, solver, because] = fields.as_slice()
    else {
        return Err(format!("a row has 8 fields, this has {}", fields.len()));
    };
    let number = |field: &str, none: f64| match field {
        "-" => Ok(none),
        field => field.parse::<f64>().map_err(|_| format!("`{field}` is no number")),
    };
    let space = match *space {
        "-" => None,
        "two-clusters" => Some(Space::TwoClusters),
        "globular" => Some(Space::Globular),
        "uniform" => Some(Space::Uniform),
        other => return Err(format!("`{other}` is no distribution: two-clusters, globular, uniform or -")),
    };
    Ok(Row {
        kind: (*kind).to_string(),
        space,
        count_max: number(count_max, f64::INFINITY)?,
        tour_share_min: number(tour_share_min, f64::NEG_INFINITY)?,
        variation_max: number(variation_max, f64::INFINITY)?,
        budget_units_min: number(budget_units_min, 0.0)?,
        solver: (*solver).to_string(),
        because: (*because).to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::single_visit::examples as fires;
    use crate::surveillance::examples;

    #[test]
    fn every_row_names_a_planner_of_its_kind() {
        let problems = [
            ("surveillance", Problem::Surveillance(examples::random(4, 1))),
            ("single-visit", Problem::SingleVisit(fires::western_states(40_000.0))),
        ];
        let rows = rows(PROFILE).unwrap();
        assert!(rows.len() >= 4);
        for row in rows {
            let (_, problem) = problems.iter().find(|(kind, _)| *kind == row.kind).unwrap();
            assert!(crate::solver(&row.solver).unwrap().serves(problem), "{row:?}");
        }
    }

    #[test]
    fn the_choice_depends_on_time_and_says_why() {
        let problem = Problem::Surveillance(examples::random(8, 1));
        let long = select(&problem);
        assert_eq!(long.solver, "anytime");
        assert!(long.reason.contains("8 targets") && long.reason.contains("one tour takes"), "{}", long.reason);
        assert_eq!(select_within(&problem, 20_000).solver, "wam");
        let equal = Problem::Surveillance(examples::equal(8, 1));
        assert_eq!(select_within(&equal, 20_000).solver, "two-opt");
        assert_eq!(select(&Problem::SingleVisit(fires::western_states(40_000.0))).solver, "single-visit");
    }

    #[test]
    fn nonsense_in_the_table_is_named_by_line() {
        let heading = "kind,space,count_max,tour_share_min,variation_max,budget_units_min,solver,because\n";
        assert_eq!(rows(&format!("{heading}a,b")).unwrap_err(), "profile.csv:2: a row has 8 fields, this has 2");
        let message = rows(&format!("# x\n{heading}surveillance,-,many,-,-,-,wam,x")).unwrap_err();
        assert_eq!(message, "profile.csv:3: `many` is no number");
    }

    #[test]
    fn a_problem_without_meaning_still_gets_an_answer() {
        let mut problem = examples::random(3, 1);
        problem.horizon_s = f64::NAN;
        let selection = select(&Problem::Surveillance(problem));
        assert_eq!(selection.solver, "nearest-neighbour");
        assert!(selection.reason.contains("cannot be classified"), "{}", selection.reason);
    }
}
