//! A tree of boxes, to find those that a leg meets.
//!
//! Bound: building O(n log n); a query O(log n + boxes met).

use crate::plane::Point;

/// Maximum number of boxes of one leaf.
const LEAF_MAX: usize = 4;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Box2 {
    low: Point,
    high: Point,
}

#[derive(Clone, Debug, PartialEq)]
enum BoxNode {
    /// Items `from..until` of the order.
    Leaf { bounds: Box2, from: usize, until: usize },
    /// A node whose children are the next node and the one at index `right`.
    Fork { bounds: Box2, right: usize },
}

/// A tree over numbered boxes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Boxes {
    nodes: Vec<BoxNode>,
    order: Vec<(usize, Box2)>,
}

impl Boxes {
    /// Returns a tree over boxes given by their south-western and north-eastern corners.
    pub(crate) fn new(boxes: impl Iterator<Item = (Point, Point)>) -> Boxes {
        let mut order: Vec<(usize, Box2)> =
            boxes.enumerate().map(|(number, (low, high))| (number, Box2 { low, high })).collect();
        let mut nodes = Vec::new();
        if !order.is_empty() {
            grow(&mut nodes, &mut order, 0);
        }
        Boxes { nodes, order }
    }

    /// Calls `found` with the number of each box that the leg may meet, until it returns true; returns true if it did.
    pub(crate) fn any(&self, a: Point, b: Point, mut found: impl FnMut(usize) -> bool) -> bool {
        let mut open = vec![0];
        while let Some(index) = open.pop() {
            match self.nodes.get(index) {
                Some(BoxNode::Leaf { bounds, from, until }) if bounds.meets(a, b) => {
                    let items = self.order.get(*from..*until).unwrap_or_default();
                    if items.iter().any(|(number, bounds)| bounds.meets(a, b) && found(*number)) {
                        return true;
                    }
                }
                Some(BoxNode::Fork { bounds, right }) if bounds.meets(a, b) => open.extend([*right, index + 1]),
                _ => {}
            }
        }
        false
    }
}

/// Adds the node for `items`, which begin at `offset`, and those below it.
fn grow(nodes: &mut Vec<BoxNode>, items: &mut [(usize, Box2)], offset: usize) {
    let empty = Box2 {
        low: Point { x: f64::INFINITY, y: f64::INFINITY },
        high: Point { x: f64::NEG_INFINITY, y: f64::NEG_INFINITY },
    };
    let bounds = items.iter().fold(empty, |all, (_, one)| all.with(one));
    if items.len() <= LEAF_MAX {
        nodes.push(BoxNode::Leaf { bounds, from: offset, until: offset + items.len() });
        return;
    }
    let wide = bounds.high.x - bounds.low.x > bounds.high.y - bounds.low.y;
    let middle = |one: &Box2| if wide { one.low.x + one.high.x } else { one.low.y + one.high.y };
    items.sort_by(|(m, a), (n, b)| middle(a).total_cmp(&middle(b)).then(m.cmp(n)));
    let fork = nodes.len();
    nodes.push(BoxNode::Fork { bounds, right: 0 });
    let half = items.len() / 2;
    let (left, right) = items.split_at_mut(half);
    grow(nodes, left, offset);
    let next = nodes.len();
    if let Some(BoxNode::Fork { right, .. }) = nodes.get_mut(fork) {
        *right = next;
    }
    grow(nodes, right, offset + half);
}

impl Box2 {
    fn with(self, other: &Box2) -> Box2 {
        Box2 {
            low: Point { x: self.low.x.min(other.low.x), y: self.low.y.min(other.low.y) },
            high: Point { x: self.high.x.max(other.high.x), y: self.high.y.max(other.high.y) },
        }
    }

    /// Returns false only if the leg certainly does not meet the box: tests the axes of the box, then the leg's normal.
    fn meets(&self, a: Point, b: Point) -> bool {
        if a.x.max(b.x) < self.low.x || a.x.min(b.x) > self.high.x {
            return false;
        }
        if a.y.max(b.y) < self.low.y || a.y.min(b.y) > self.high.y {
            return false;
        }
        let along = b.minus(a);
        let middle = Point { x: 0.5 * (self.low.x + self.high.x), y: 0.5 * (self.low.y + self.high.y) };
        let (half_x, half_y) = (0.5 * (self.high.x - self.low.x), 0.5 * (self.high.y - self.low.y));
        let beside = along.cross(middle.minus(a)).abs();
        beside <= (half_x * along.y.abs() + half_y * along.x.abs()) * (1.0 + 1e-9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_box_that_a_leg_meets_is_found(
            boxes in prop::collection::vec((0.0..100.0f64, 0.0..100.0f64, 0.0..20.0f64, 0.0..20.0f64), 0..40),
            ends in (0.0..100.0f64, 0.0..100.0f64, 0.0..100.0f64, 0.0..100.0f64),
        ) {
            let (a, b) = (Point { x: ends.0, y: ends.1 }, Point { x: ends.2, y: ends.3 });
            let tree = Boxes::new(boxes.iter().map(|(x, y, w, h)| (Point { x: *x, y: *y }, Point { x: x + w, y: y + h })));
            let mut found = vec![false; boxes.len()];
            tree.any(a, b, |number| { found[number] = true; false });
            for (number, (x, y, w, h)) in boxes.iter().enumerate() {
                let met = (0..=400).any(|step| {
                    let here = a.plus(f64::from(step) / 400.0, b.minus(a));
                    *x <= here.x && here.x <= x + w && *y <= here.y && here.y <= y + h
                });
                prop_assert!(found[number] || !met);
            }
        }
    }
}
