//! An altitude that is set while a way or path with altitudes is flown: it replaces them until the next flight command.

use crate::flight::{ActiveOrder, Order, Stage};

impl ActiveOrder {
    /// Drops the altitudes of the way or path. A landing keeps its altitudes: an aircraft that climbed would pass its field.
    pub(crate) fn level(&mut self) {
        if matches!(self.order, Order::Land { .. }) {
            return;
        }
        if let Some(way) = &mut self.way {
            way.level();
        }
        if let Stage::Follow(path) = &mut self.stage {
            path.level();
        }
    }
}
