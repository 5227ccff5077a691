//! Input and output of one step of an agent.

use apex_model::effect::Effect;
use apex_model::event::Batch;

/// One executive step of one agent.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Input.
    pub batch: Batch,
    /// Output.
    pub effects: Vec<Effect>,
}
