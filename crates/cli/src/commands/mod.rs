//! One file per command.
pub mod check;
pub mod explain;
pub mod export;
mod fix;
pub mod fly;
pub mod fork;
pub mod format;
pub mod monitor;
pub mod plan;
pub mod profile;
pub mod replay;
pub mod run;
pub mod serve;
pub mod trace;
pub mod why;
pub mod why_not;
