//! Random worlds: a tree of tasks with needs, priorities, ranks and costs, and the events that start and stop them. Written as PDL.

use proptest::prelude::*;
use std::ops::Range;

/// Names and totals of the resources: two indivisible, one with three units, one depletable.
pub const RESOURCES: [(&str, f64); 4] = [("camera", 1.0), ("path", 1.0), ("link", 3.0), ("fuel", 10.0)];
/// The index of the resource that is used up.
pub const FUEL: usize = 3;

/// A task: a leaf that works until it is stopped, or a group with tasks below it.
#[derive(Clone, Debug)]
pub struct Node {
    /// The group that contains it; `None` for a step of the root.
    pub parent: Option<usize>,
    pub is_group: bool,
    /// A group of kind `:ranked`: its steps have the ranks 1 to n.
    pub ranked: bool,
    /// True if it waits for its own message `(go N)`.
    pub waits: bool,
    /// Amount of each resource; 0 is no need.
    pub needs: [u8; 4],
    pub priority: Option<f64>,
    pub rank: Option<i32>,
    pub cost: Option<f64>,
    /// Stated duration in seconds, which need not be true.
    pub expected: Option<u32>,
}

/// Event of one instant.
#[derive(Clone, Debug)]
pub enum Moment {
    /// The tasks that may begin, and the tasks that are stopped.
    Changes(Vec<usize>, Vec<usize>),
    Hold(usize),
    Free(usize),
}

/// A tree and its story.
#[derive(Clone)]
pub struct World {
    pub nodes: Vec<Node>,
    pub moments: Vec<Moment>,
}

impl std::fmt::Debug for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{:?}", self.pdl(), self.moments)
    }
}

fn node(index: usize, ranked_share: f64, expected_share: f64) -> impl Strategy<Value = Node> {
    let parent = prop::option::weighted(0.7, 0..index.max(1));
    let priority = prop::option::weighted(0.6, prop::sample::select(vec![0.0, 0.1, 1.0, 1.1, 2.0, 3.0]));
    let cost = prop::option::weighted(0.3, prop::sample::select(vec![0.0, 1.0, 2.0]));
    let needs = prop::sample::select(vec![
        [1, 0, 0, 0],
        [1, 0, 0, 0],
        [0, 1, 0, 0],
        [1, 1, 0, 0],
        [0, 0, 1, 0],
        [0, 0, 2, 0],
        [0, 0, 3, 0],
        [1, 0, 1, 0],
        [0, 1, 2, 0],
        [0, 0, 0, 3],
        [0, 0, 0, 6],
        [1, 0, 0, 4],
        [0, 0, 0, 0],
    ]);
    let rank = prop::option::weighted(ranked_share, 1..4_i32);
    let expected = prop::option::weighted(expected_share, prop::sample::select(vec![0, 1, 2, 3, 5, 8, 13]));
    let kind = (any::<bool>(), prop::bool::weighted(0.2), prop::bool::weighted(0.6));
    (parent, kind, needs, priority, rank, cost, expected).prop_map(
        move |(parent, (is_group, ranked, waits), needs, priority, rank, cost, expected)| Node {
            parent: parent.filter(|parent| *parent < index),
            is_group,
            ranked,
            waits,
            needs,
            priority,
            rank,
            cost,
            expected,
        },
    )
}

/// Returns a random world of up to nine tasks; `ranked_share` of them have ranks, which can contradict priorities, and
/// `expected_share` an expected duration.
pub fn worlds(ranked_share: f64, expected_share: f64) -> impl Strategy<Value = World> {
    worlds_of(2..10, ranked_share, expected_share)
}

/// Returns worlds like [`worlds`], with `count` tasks.
pub fn worlds_of(count: Range<usize>, ranked_share: f64, expected_share: f64) -> impl Strategy<Value = World> {
    count.prop_flat_map(move |count| {
        let nodes: Vec<_> = (0..count).map(|index| node(index, ranked_share, expected_share)).collect();
        let some = move || prop::collection::vec(0..count, 0..5);
        let moment = prop_oneof![
            6 => (some(), prop::collection::vec(0..count, 0..2)).prop_map(|(go, stop)| Moment::Changes(go, stop)),
            2 => (0..count).prop_map(Moment::Hold),
            2 => (0..count).prop_map(Moment::Free),
        ];
        (nodes, prop::collection::vec(moment, 4..24)).prop_map(|(mut nodes, moments)| {
            // A leaf has no children; an empty group would end at once.
            for index in 0..nodes.len() {
                let above = nodes[index].parent.filter(|parent| nodes[*parent].is_group);
                nodes[index].parent = above;
            }
            for index in 0..nodes.len() {
                nodes[index].is_group &= nodes.iter().any(|other| other.parent == Some(index));
            }
            World { nodes, moments }
        })
    })
}

impl World {
    /// Returns the world as a program.
    pub fn pdl(&self) -> String {
        let mut text = String::from("(resource link :capacity 3)\n(resource fuel :depletable 10kg)\n");
        text.push_str("(procedure (index (do-domain))\n  (step keep (rest))");
        text.push_str(&self.steps(None));
        text.push_str(")\n(primitive (index (rest)) (duration 10000s))\n");
        for (index, node) in self.nodes.iter().enumerate() {
            let profile = profile(node);
            if node.is_group {
                let kind = if node.ranked { " :ranked" } else { "" };
                let steps = self.steps(Some(index));
                let expected = expected(node);
                text.push_str(&format!("(procedure{kind} (index (work {index})){profile}{expected}{steps})\n"));
            } else if node.expected.is_some() {
                let expected = expected(node);
                text.push_str(&format!("(procedure (index (work {index})){profile}{expected} (step inner (rest)))\n"));
            } else {
                text.push_str(&format!(
                    "(primitive (index (work {index})){profile} (on-start (command (work {index}))))\n"
                ));
            }
        }
        text
    }

    fn steps(&self, parent: Option<usize>) -> String {
        let children = self.nodes.iter().enumerate().filter(|(_, node)| node.parent == parent);
        children.map(|(index, node)| step(index, node)).collect()
    }
}

fn step(index: usize, node: &Node) -> String {
    let mut text = format!("\n  (step t{index} (work {index}) (end-when (stop {index}))");
    text.push_str(&format!(" (suspend-when (hold {index}) until (free {index})) (on-failure (print failed))"));
    if node.waits {
        text.push_str(&format!(" (waitfor (go {index}))"));
    }
    if let Some(priority) = node.priority {
        text.push_str(&format!(" (priority {priority})"));
    }
    if let Some(rank) = node.rank {
        text.push_str(&format!(" (rank {rank})"));
    }
    if let Some(cost) = node.cost {
        text.push_str(&format!(" (interrupt-cost {cost})"));
    }
    text + ")"
}

fn expected(node: &Node) -> String {
    node.expected.map(|seconds| format!(" (expected-duration {seconds}s)")).unwrap_or_default()
}

fn profile(node: &Node) -> String {
    let needs = node.needs.iter().zip(RESOURCES).enumerate().filter(|(_, (amount, _))| **amount > 0);
    let words = needs.map(|(index, (amount, (name, total)))| match index {
        FUEL => format!(" (fuel ({amount} kg))"),
        _ if total == 1.0 => format!(" {name}"),
        _ => format!(" ({name} {amount})"),
    });
    let words: String = words.collect();
    if words.is_empty() { words } else { format!(" (profile{words})") }
}
