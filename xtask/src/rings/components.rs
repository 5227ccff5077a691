//! Strongly connected components of a directed graph: sets of nodes that can all reach each other.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Targets of each node.
pub(crate) type Graph<'a> = BTreeMap<&'a str, BTreeSet<&'a str>>;

/// Rings of more than one node, each ordered by name, the largest ring first.
pub(crate) fn rings<'a>(graph: &Graph<'a>) -> Vec<Vec<&'a str>> {
    let mut backward: Graph<'a> = BTreeMap::new();
    for (from, targets) in graph {
        for to in targets {
            backward.entry(to).or_default().insert(from);
        }
    }
    let mut rings = Vec::new();
    let mut left: BTreeSet<&str> = graph.keys().copied().collect();
    while let Some(first) = left.first().copied() {
        let ahead = reached(graph, first);
        let behind = reached(&backward, first);
        let ring: Vec<&str> = ahead.intersection(&behind).copied().collect();
        left.remove(first);
        for node in &ring {
            left.remove(node);
        }
        if ring.len() > 1 {
            rings.push(ring);
        }
    }
    rings.sort_by_key(|ring| (std::cmp::Reverse(ring.len()), ring.clone()));
    rings
}

/// Returns a shortest way from `from` back to itself through `to`, which `from` imports; without the repeated last node.
pub(crate) fn way_back<'a>(graph: &Graph<'a>, from: &'a str, to: &'a str) -> Vec<&'a str> {
    let mut before: BTreeMap<&str, &str> = BTreeMap::from([(to, from)]);
    let mut queue = VecDeque::from([to]);
    while let Some(node) = queue.pop_front() {
        if node == from {
            break;
        }
        for next in graph.get(node).into_iter().flatten() {
            if !before.contains_key(next) {
                before.insert(next, node);
                queue.push_back(next);
            }
        }
    }
    let mut way = Vec::new();
    let mut node = from;
    while let Some(previous) = before.get(node).copied().filter(|previous| *previous != from) {
        way.push(previous);
        node = previous;
    }
    way.push(from);
    way.reverse();
    way
}

fn reached<'a>(graph: &Graph<'a>, first: &'a str) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::from([first]);
    let mut open = vec![first];
    while let Some(node) = open.pop() {
        for next in graph.get(node).into_iter().flatten() {
            if reached.insert(next) {
                open.push(next);
            }
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_and_a_way_through_them_are_found() {
        let graph: Graph<'_> =
            [("a", "b"), ("b", "c"), ("c", "a"), ("c", "d"), ("d", "e"), ("e", "d"), ("x", "a"), ("b", "a")]
                .into_iter()
                .fold(Graph::new(), |mut graph, (from, to)| {
                    graph.entry(from).or_default().insert(to);
                    graph
                });
        assert_eq!(rings(&graph), [vec!["a", "b", "c"], vec!["d", "e"]]);
        assert_eq!(way_back(&graph, "c", "a"), ["c", "a", "b"]);
        assert_eq!(way_back(&graph, "d", "e"), ["d", "e"]);
    }
}
