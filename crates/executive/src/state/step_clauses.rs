//! Kinds of clauses that a step has: most steps have few, and the executive evaluates only those.

use apex_model::procedure::{ProcedureKind, Step, Transitions};

/// Kinds of clauses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepClauses(u16);

impl StepClauses {
    /// No clauses.
    pub const NONE: StepClauses = StepClauses(0);
    /// `on-start`, `on-end` and the like.
    pub const HOOKS: StepClauses = StepClauses(1);
    /// `end-when`, `suspend-when`, `skip-when` and the like.
    pub const TRANSITIONS: StepClauses = StepClauses(1 << 1);
    /// `select`.
    pub const SELECT: StepClauses = StepClauses(1 << 2);
    /// `=>`.
    pub const RESULT: StepClauses = StepClauses(1 << 3);
    /// `repeating`, `responding`.
    pub const REPETITION: StepClauses = StepClauses(1 << 4);
    /// `waitfor`.
    pub const WAITFOR: StepClauses = StepClauses(1 << 5);
    /// The step uses results of other steps.
    pub const AWAITS: StepClauses = StepClauses(1 << 6);
    /// `profile`, `priority`, `rank`, `interrupt-cost`.
    pub const CONTENTION: StepClauses = StepClauses(1 << 7);
    /// `rank`, or a place in a procedure whose steps are ranked by their order.
    pub const RANK: StepClauses = StepClauses(1 << 8);
    /// `precondition`, `invariant`.
    pub const EXECUTION: StepClauses = StepClauses(1 << 9);
    /// The clauses are unknown: every kind must be checked.
    pub const UNKNOWN: StepClauses = StepClauses(u16::MAX);

    /// Returns the clauses of `step` of a procedure of this kind; `awaits` is true if it uses results of other steps.
    pub fn of(step: &Step, kind: ProcedureKind, awaits: bool) -> StepClauses {
        let Transitions {
            end_when,
            restart_when,
            resume_when,
            suspend_when,
            suspend_until,
            skip_when,
            exit_when,
            precondition,
            invariant,
        } = &step.transitions;
        let transitions = [end_when, restart_when, resume_when, suspend_when, suspend_until, skip_when, exit_when];
        let hooks = [&step.hooks.on_start, &step.hooks.on_end, &step.hooks.on_suspend, &step.hooks.on_resume];
        let ranked = matches!(kind, ProcedureKind::Ranked | ProcedureKind::SoftSequential) || step.rank.is_some();
        let contention = !step.profile.is_empty() || !step.priority.is_empty();
        let present = [
            (StepClauses::HOOKS, hooks.into_iter().any(|forms| !forms.is_empty())),
            (StepClauses::TRANSITIONS, transitions.into_iter().any(Option::is_some)),
            (StepClauses::EXECUTION, precondition.is_some() || invariant.is_some()),
            (StepClauses::SELECT, !step.select.is_empty()),
            (StepClauses::RESULT, step.binds.is_some()),
            (StepClauses::REPETITION, step.repeating.is_some() || step.responding.is_some()),
            (StepClauses::WAITFOR, !step.waitfor.is_empty()),
            (StepClauses::AWAITS, awaits),
            (StepClauses::RANK, ranked),
            (StepClauses::CONTENTION, contention || step.rank.is_some() || step.interrupt_cost.is_some()),
        ];
        let kinds = present.into_iter().filter(|(_, is_present)| *is_present);
        kinds.fold(StepClauses::NONE, |all, (kind, _)| StepClauses(all.0 | kind.0))
    }

    /// Returns true if the step has one of `kinds`.
    #[inline]
    pub fn has(self, kinds: StepClauses) -> bool {
        self.0 & kinds.0 != 0
    }
}

/// Before the step of a task is known, every kind of clause must be checked.
impl Default for StepClauses {
    fn default() -> StepClauses {
        StepClauses::UNKNOWN
    }
}
