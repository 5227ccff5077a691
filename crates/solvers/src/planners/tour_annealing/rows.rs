//! Rows of lanes that can be removed and inserted without moving the other rows.

use smallvec::SmallVec;

/// Rows in order. Each lies anywhere in memory; only their order is a list.
#[derive(Clone, Debug)]
pub(super) struct Rows<T> {
    width: usize,
    order: Vec<u32>,
    free: Vec<u32>,
    lanes: Vec<T>,
    fresh: T,
}

impl<T: Copy> Rows<T> {
    /// Returns an empty list of rows; each row will have `width` lanes, which are `fresh` at first.
    pub(super) fn new(width: usize, fresh: T) -> Rows<T> {
        Rows { width, order: Vec::new(), free: Vec::new(), lanes: Vec::new(), fresh }
    }

    /// Returns the lanes at `place`; empty beyond the last.
    #[inline(always)]
    pub(super) fn at(&self, place: usize) -> &[T] {
        let begin = self.begin(place);
        begin.and_then(|begin| self.lanes.get(begin..begin + self.width)).unwrap_or(&[])
    }

    /// Returns the row at `place`, mutably.
    #[inline(always)]
    pub(super) fn at_mut(&mut self, place: usize) -> &mut [T] {
        let (begin, width) = (self.begin(place), self.width);
        begin.and_then(|begin| self.lanes.get_mut(begin..begin + width)).unwrap_or_default()
    }

    #[inline(always)]
    fn begin(&self, place: usize) -> Option<usize> {
        self.order.get(place).map(|row| *row as usize * self.width)
    }

    /// Writes the row at `to` from the one at `from`, applying `map` to each lane.
    #[inline(always)]
    pub(super) fn derive(&mut self, to: usize, from: usize, map: impl Fn(T) -> T) {
        let (Some(to), Some(from)) = (self.begin(to), self.begin(from)) else { return };
        let middle = to.max(from);
        let Some((before, after)) = self.lanes.split_at_mut_checked(middle) else { return };
        let low = before.get_mut(to.min(from)..).and_then(|low| low.get_mut(..self.width)).unwrap_or_default();
        let high = after.get_mut(..self.width).unwrap_or_default();
        let (source, target) = if from < to { (low, high) } else { (high, low) };
        for (slot, lane) in target.iter_mut().zip(source.iter()) {
            *slot = map(*lane);
        }
    }

    /// Replaces the rows `from..until` by `count` rows, whose lanes the caller writes.
    pub(super) fn splice(&mut self, from: usize, until: usize, count: usize) {
        let from = from.min(self.order.len());
        let until = until.clamp(from, self.order.len());
        // As many replaced rows as possible keep their memory: the caller overwrites their lanes.
        let both = count.min(until - from);
        let more = count - both;
        while self.free.len() < more {
            self.free.push((self.lanes.len() / self.width.max(1)) as u32);
            self.lanes.resize(self.lanes.len() + self.width, self.fresh);
        }
        let fresh = self.free.len() - more;
        let gone = self.order.splice(from + both..until, self.free.drain(fresh..));
        let gone: SmallVec<[u32; 8]> = gone.collect();
        self.free.extend(gone);
    }
}
