//! Folds the steps of a record into two values at once: one needs inputs and effects, the other inputs alone.
//!
//! The second fold runs on its own thread, behind the first. Each value is a function of the steps in order, so the threads influence
//! only the duration.

use super::steps::{RecordedStep, Steps};
use crate::error::RecordError;
use apex_model::event::Batch;
use std::sync::mpsc::sync_channel;
use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, scope};

/// Maximum number of batches that the second fold may be behind.
const BEHIND_MAX: usize = 4_096;

/// Folds `steps` with `fold`, and the batches of agent 0 into the second value with `see`.
///
/// # Errors
/// The result of `fold`, or that of `damaged` for a record that cannot be read.
pub fn fold_both<S: Send, E>(
    steps: Steps<'_>,
    (second, see): (&mut S, impl Fn(&mut S, &Batch) + Sync),
    mut fold: impl FnMut(&RecordedStep) -> Result<(), E>,
    damaged: impl Fn(RecordError) -> E,
) -> Result<(), E> {
    let second = Mutex::new(second);
    scope(|threads| {
        let (sender, receiver) = sync_channel::<Batch>(BEHIND_MAX);
        let work = || {
            let receiver = receiver;
            let mut second = second.lock().unwrap_or_else(PoisonError::into_inner);
            while let Ok(batch) = receiver.recv() {
                see(&mut second, &batch);
            }
        };
        // If the system provides no thread, both folds run here.
        let worker = Builder::new().name("record fold".to_string()).spawn_scoped(threads, work);
        let sender = worker.is_ok().then_some(sender);
        for step in steps {
            let step = step.map_err(&damaged)?;
            fold(&step)?;
            if step.agent != 0 {
                continue;
            }
            match &sender {
                Some(sender) => drop(sender.send(step.batch)),
                None => see(&mut second.lock().unwrap_or_else(PoisonError::into_inner), &step.batch),
            }
        }
        Ok(())
    })
}
