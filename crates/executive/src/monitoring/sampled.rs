//! Sampled parts (M&I)
//! What: passes samples to the parts that watch a state variable, one by one, and again from the remembered samples.
//! Runs: when a monitor is created or notices a sample.
//! Reads: histories, evaluation context.
//! Writes: the part.
//! Bound: O(1) plus the part's own bound; looking back O(samples in the window).
//! PDL: `(ATTR OBJ)`.
//! Paper: section III, histories.

use super::constraints::satisfies_all;
use super::part::{ConditionFaults, PartContext};
use super::samples::{Arrival, SampleView, arrival, concerns, object_holds, remembered};
use crate::expression::{EvalContext, EvaluationError};
use crate::planted::{self, Bug};
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::Test;
use crate::state::monitors::monitor::Window;
use apex_model::condition::{Constraint, VariablePattern};
use apex_model::event::StateVariable;
use apex_model::time::Time;
use apex_model::value::Value;

/// A part that receives the samples of a state variable one by one, those of one object in order of time.
pub(crate) trait Sampled {
    /// Returns the state variable as written in the condition.
    fn pattern(&self) -> &VariablePattern;
    /// Returns the state variable, if its object is known.
    fn variable(&self) -> Option<&StateVariable>;
    /// Returns the instant of the newest sample of `object` that the part has processed.
    fn newest(&self, object: &Value) -> Option<Time>;
    /// Returns the window of samples that count.
    fn window(&self, site: PartContext) -> Window {
        site.window
    }
    /// Clears the results of samples.
    fn begin_again(&mut self, site: PartContext, context: &dyn EvalContext, troubles: &mut ConditionFaults);
    /// Notes whether the window reaches before the oldest sample kept, and the first sample in it.
    fn note_blind(&mut self, blind: bool, first: Option<Time>);
    /// Takes in a sample that is not older than the newest of its object.
    fn feed(
        &mut self,
        site: PartContext,
        sample: SampleView<'_>,
        context: &dyn EvalContext,
        troubles: &mut ConditionFaults,
    );
    /// Adds a sample if that needs no evaluation of expressions; otherwise returns false and changes nothing.
    fn feed_quickly(&mut self, site: PartContext, sample: SampleView<'_>) -> bool {
        let _ = (site, sample);
        false
    }
    /// Returns true if the sample replaces another one that the part cannot remove alone.
    fn must_backfill(&self, sample: SampleView<'_>) -> bool {
        let _ = sample;
        false
    }
    /// Clears the results and processes the remembered samples.
    fn backfill(&mut self, site: PartContext, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
        self.begin_again(site, context, troubles);
        let (known, attribute) = (self.variable().cloned(), self.pattern().attribute.clone());
        let within = PartContext { window: self.window(site), ..site };
        let (samples, blind) = remembered(known.as_ref(), &attribute, within, context);
        self.note_blind(blind, samples.first().map(|sample| sample.at));
        for sample in samples {
            self.feed(site, sample, context, troubles);
        }
    }
}

/// Processes a sample.
pub(crate) fn notice(
    part: &mut impl Sampled,
    site: PartContext,
    sample: SampleView<'_>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if !concerns(part.variable(), &part.pattern().attribute, sample.variable) || part.feed_quickly(site, sample) {
        return;
    }
    match arrival(part.window(site), sample, part.newest(&sample.variable.object), context) {
        Arrival::Late if planted::is(Bug::LateSampleIgnored) => {}
        Arrival::Late => part.backfill(site, context, troubles),
        Arrival::Next if part.must_backfill(sample) => part.backfill(site, context, troubles),
        Arrival::Next => part.feed(site, sample, context, troubles),
        Arrival::Nothing => {}
    }
}

/// Constraints of a condition on the object and the value of a sample.
pub(crate) struct SampleConstraints<'a> {
    /// The state variable.
    pub(crate) pattern: &'a VariablePattern,
    /// Constraints on the object.
    pub(crate) object: &'a [Constraint],
    /// Constraints on the value.
    pub(crate) value: &'a [Constraint],
    /// The constraints on the value, in a form prepared for comparison.
    pub(crate) tests: &'a [Test],
    /// True if the object is known, so that it needs no matching.
    pub(crate) known: bool,
}

impl SampleConstraints<'_> {
    /// Returns true if the sample satisfies them; adds their bindings.
    ///
    /// # Errors
    /// If an expression in them cannot be evaluated.
    pub(crate) fn hold(
        &self,
        site: PartContext,
        sample: SampleView<'_>,
        bindings: &mut Bindings,
        context: &dyn EvalContext,
    ) -> Result<bool, EvaluationError> {
        let SampleView { variable, value, .. } = sample;
        Ok(object_holds(self.pattern, self.object, self.known, variable, bindings, site, context)?
            && satisfies_all(self.tests, self.value, value, &variable.attribute, bindings, context, site.place)?)
    }
}

/// Returns the bindings by the name of a sample's object; `None` if the object does not satisfy `constraints`.
pub(crate) fn object_bindings(
    part: &impl Sampled,
    constraints: &[Constraint],
    site: PartContext,
    sample: SampleView<'_>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> Option<Bindings> {
    let mut bindings = Bindings::new();
    let known = part.variable().is_some();
    match object_holds(part.pattern(), constraints, known, sample.variable, &mut bindings, site, context) {
        Ok(holds) => holds.then_some(bindings),
        Err(error) => {
            troubles.add(error);
            None
        }
    }
}
