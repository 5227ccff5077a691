//! Re-derivation: checks every stated cause against its record.

mod causes;
mod ends;
mod evidence;
pub mod mutation;
mod numbers;
mod probing;
mod require;
mod step;
mod thresholds;
mod violations;
mod world;

use apex_model::because::Because;
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::library::Library;
use apex_runtime::ports::Observer;
use std::collections::BTreeMap;
pub use step::Step;
use world::World;

/// A stated cause that does not follow from the record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Complaint {
    /// The step, from 0.
    pub step: usize,
    /// The index of the effect in the step, from 0.
    pub effect: usize,
    /// The kind of cause.
    pub kind: &'static str,
    /// The discrepancy.
    pub what: String,
}

/// Returns the cause of an effect, if it states one.
pub fn because_of(effect: &Effect) -> Option<&Because> {
    match effect {
        Effect::Decided(decision) => Some(&decision.because),
        Effect::Command { because, .. } => Some(because),
        _ => None,
    }
}

/// Derives every cause again and returns the discrepancies; a correct record has none.
pub fn complaints(library: &Library, steps: &[Step]) -> Vec<Complaint> {
    let mut world = World::new(library);
    let mut found = Vec::new();
    for (number, step) in steps.iter().enumerate() {
        world.hear(step);
        for (index, effect) in step.effects.iter().enumerate() {
            if let Some(because) = because_of(effect)
                && let Err(what) = causes::check(&world, step, index, effect, because)
            {
                found.push(Complaint { step: number, effect: index, kind: because.cause.kind(), what });
            }
            world.take(index, effect);
        }
    }
    found
}

/// Collects the steps of each agent.
#[derive(Default)]
pub struct Collector {
    turn: usize,
    /// By agent.
    pub steps: BTreeMap<usize, Vec<Step>>,
}

impl Observer for Collector {
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        self.turn = agent;
        Ok(())
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        let step = Step { batch: batch.clone(), effects: effects.to_vec() };
        self.steps.entry(self.turn).or_default().push(step);
        Ok(())
    }
}
