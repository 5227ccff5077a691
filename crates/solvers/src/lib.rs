//! apex-solvers
