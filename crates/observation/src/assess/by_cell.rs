//! The looks of each cell, collected from the passes.

use crate::looks::{CellLook, TargetPass};

/// The passes of a target with, for each cell, its looks as pairs of pass and look, in order of the passes.
pub(super) struct ByCell<'a> {
    pub(super) passes: Vec<&'a TargetPass>,
    offsets: Vec<u32>,
    entries: Vec<(u32, u32)>,
}

impl<'a> ByCell<'a> {
    pub(super) fn new(passes: Vec<&'a TargetPass>, cells: usize) -> ByCell<'a> {
        let mut offsets = vec![0_u32; cells + 2];
        for look in passes.iter().flat_map(|pass| &pass.looks) {
            if let Some(count) = offsets.get_mut(look.cell as usize + 2) {
                *count += 1;
            }
        }
        let mut sum = 0;
        for offset in &mut offsets {
            sum += *offset;
            *offset = sum;
        }
        let mut entries = vec![(0, 0); sum as usize];
        for (pass_index, pass) in passes.iter().enumerate() {
            for (look_index, look) in pass.looks.iter().enumerate() {
                let Some(next) = offsets.get_mut(look.cell as usize + 1) else { continue };
                if let Some(entry) = entries.get_mut(*next as usize) {
                    *entry = (pass_index as u32, look_index as u32);
                }
                *next += 1;
            }
        }
        ByCell { passes, offsets, entries }
    }

    pub(super) fn of(&self, cell: usize) -> &[(u32, u32)] {
        match (self.offsets.get(cell), self.offsets.get(cell + 1)) {
            (Some(from), Some(to)) => self.entries.get(*from as usize..*to as usize).unwrap_or(&[]),
            _ => &[],
        }
    }

    pub(super) fn look(&self, entry: (u32, u32)) -> Option<&CellLook> {
        self.passes.get(entry.0 as usize)?.looks.get(entry.1 as usize)
    }
}
