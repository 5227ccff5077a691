//! The imperative shell: clock, inbox, outbox, solver pool, flight record, replay, ports.

pub mod ports;
