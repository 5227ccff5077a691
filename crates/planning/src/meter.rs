//! Budget of a proof, with the used part: proofs, like planners, are budgeted in units of work, never by a clock.
//!
//! The loops of proofs are metered in nanoseconds, as measured on one core of a loaded server, and charged in whole units, so that equal
//! budgets prove equal bounds on every computer. A proof with too small a budget uses a coarser grid and reports that.

use crate::solver::{Budget, WORK_UNIT};

/// A budget with its used part, and whether the proof was cut because of it.
pub struct Meter<'a> {
    budget: &'a mut dyn Budget,
    /// Nanoseconds of recorded work that do not make up a whole unit yet.
    spent_ns: u64,
    cut: bool,
}

impl<'a> Meter<'a> {
    /// Returns a meter that charges `budget`.
    pub fn new(budget: &'a mut dyn Budget) -> Meter<'a> {
        Meter { budget, spent_ns: 0, cut: false }
    }

    /// Returns the units spent so far.
    pub fn used(&self) -> u64 {
        self.budget.used()
    }

    /// Returns true if a greater budget would have added nothing.
    pub fn is_complete(&self) -> bool {
        !self.cut
    }

    /// Returns the remaining nanoseconds; if a clock decides, infinity until the clock ends the proof.
    pub fn left_ns(&self) -> f64 {
        if self.budget.exhausted() {
            return 0.0;
        }
        self.budget.left().map_or(f64::INFINITY, |units| units as f64 * unit_ns())
    }

    /// Records work of this many nanoseconds.
    pub fn spend(&mut self, nanoseconds: f64) {
        let unit_ns = WORK_UNIT.0.unsigned_abs();
        self.spent_ns = self.spent_ns.saturating_add(nanoseconds as u64);
        self.budget.charge(self.spent_ns / unit_ns);
        self.spent_ns %= unit_ns;
    }

    /// Records that a part was left out or computed more coarsely because the budget is too small.
    pub fn cut(&mut self) {
        self.cut = true;
    }

    /// Returns the budget itself, for callers that charge it in units.
    pub fn budget(&mut self) -> &mut dyn Budget {
        self.budget
    }
}

fn unit_ns() -> f64 {
    WORK_UNIT.0 as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::WorkBudget;

    #[test]
    fn whole_units_are_charged_and_rests_are_kept() {
        let mut budget = WorkBudget::new(10);
        let mut meter = Meter::new(&mut budget);
        assert_eq!(meter.left_ns(), 10_000.0);
        meter.spend(2_700.0);
        meter.spend(400.0);
        assert_eq!((meter.used(), meter.left_ns(), meter.is_complete()), (3, 7_000.0, true));
        meter.spend(1e300);
        meter.cut();
        assert_eq!((meter.left_ns(), meter.is_complete()), (0.0, false));
    }
}
