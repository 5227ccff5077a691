//! The result of checking a record, as text and as JSON.

use super::{FileSeal, Integrity};
use serde_json::{Value, json};
use std::fmt;

impl fmt::Display for Integrity {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Integrity { file, groups, steps, until, damage, earlier, fault } = self;
        if let Some(damage) = damage {
            return write!(out, "damaged; {damage}");
        }
        if let Some(fault) = fault {
            return write!(out, "damaged; {fault}");
        }
        let file = match file {
            FileSeal::Intact => "the file is as it was closed",
            FileSeal::None => {
                "the file does not end with a seal: its flight continues, was cut off, or bytes were appended"
            }
            FileSeal::Broken => "bytes of the file have changed since it was closed, but none of a row or index",
        };
        write!(out, "{steps} steps up to {until} in {groups} groups are as they were written; {file}")?;
        let names: Vec<String> = earlier.iter().map(|path| path.display().to_string()).collect();
        if names.is_empty() { Ok(()) } else { write!(out, "; it continues {}", names.join(", ")) }
    }
}

impl Integrity {
    /// Returns the members of `apex verify --json`: `intact`, `file` (`intact`, `unsealed`, `changed`), `groups`, `steps`, `until_s`
    /// (seconds of mission time), `damage` and `fault` (null in a record without error).
    pub fn json(&self) -> Value {
        let damage = self.damage.as_ref().map(|damage| {
            json!({
                "group": damage.group,
                "trusted_steps": damage.trusted_batches,
                "trusted_until_s": damage.trusted_until.seconds(),
                "reason": damage.reason,
            })
        });
        let file = match self.file {
            FileSeal::Intact => "intact",
            FileSeal::None => "unsealed",
            FileSeal::Broken => "changed",
        };
        json!({
            "intact": self.is_intact(),
            "file": file,
            "groups": self.groups,
            "steps": self.steps,
            "until_s": self.until.seconds(),
            "damage": damage,
            "earlier": self.earlier.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
            "fault": self.fault,
        })
    }
}
