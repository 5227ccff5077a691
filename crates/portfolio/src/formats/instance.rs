//! A benchmark problem as it was read.

use apex_model::problem::SingleVisitProblem;

/// Kind of problem that a file poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProblemKind {
    /// The most value within time windows and a closing time.
    OrienteeringWithWindows,
    /// The most value within a length.
    Orienteering,
    /// The shortest tour of all.
    Tour,
}

/// A problem as stated in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// Its name: the file's own, or that of the file.
    pub name: String,
    /// The format, as text.
    pub format: &'static str,
    /// Kind of problem.
    pub question: ProblemKind,
    /// Number of vehicles (paths) in the file; the problem is that of one vehicle.
    pub vehicles: Option<usize>,
    /// The problem.
    pub problem: SingleVisitProblem,
}
