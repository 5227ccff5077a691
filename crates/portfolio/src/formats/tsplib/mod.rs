//! TSPLIB and OPLib: `KEY : VALUE` lines and sections of numbers.
//!
//! `TYPE` TSP and ATSP request the shortest tour of all nodes, OP the greatest score within `COST_LIMIT`. The tour begins and ends at the
//! first node of `DEPOT_SECTION`, or at node 1.

mod header;
mod weights;

use super::instance::{Instance, ProblemKind};
use super::pose::{self, Frame, Vertex};
use super::words::{self, TextToken, ends_early};
use crate::format_error::FormatError;
use header::Header;
use weights::Weights;

const HELP: &str = "docs/reference/planning-problems.md lists what is read";

/// Returns true if one of the first lines is `NAME`, `TYPE` or `DIMENSION` with a colon.
pub(super) fn is_one(text: &str) -> bool {
    let known = ["NAME", "TYPE", "DIMENSION", "COMMENT", "EDGE_WEIGHT_TYPE"];
    let mut lines = words::lines(text).filter(|line| !line.is_empty()).take(8);
    lines.any(|line| {
        let whole = line.first().map_or("", |word| word.whole_line);
        whole.split_once(':').is_some_and(|(key, _)| known.contains(&key.trim().to_uppercase().as_str()))
    })
}

/// Sections of a file.
#[derive(Default)]
struct Sections {
    places: Option<Vec<(f64, f64)>>,
    weights: Option<Vec<f64>>,
    scores: Option<Vec<f64>>,
    depot: Option<usize>,
}

/// Reads a file.
pub(super) fn read(name: &str, text: &str) -> Result<Instance, FormatError> {
    let mut header = Header::default();
    let mut sections = Sections::default();
    let mut lines = words::lines(text).filter(|line| !line.is_empty()).peekable();
    while let Some(line) = lines.next() {
        let Some(first) = line.first().copied() else { continue };
        let (key, value) = header::split(&first);
        if key == "EOF" {
            break;
        }
        if !key.ends_with("_SECTION") {
            header.set(&key, value, &first)?;
            continue;
        }
        let mut numbers: Vec<TextToken<'_>> = line.iter().skip(1).filter(|word| word.text != ":").copied().collect();
        while let Some(more) = lines.next_if(|line| line.first().is_some_and(|word| begins_number(word.text))) {
            numbers.extend(more);
        }
        section(&key, &first, &numbers, &header, &mut sections)?;
    }
    finish(name, text, &header, sections)
}

fn begins_number(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+' || c == '.')
}

fn section(
    key: &str,
    at: &TextToken<'_>,
    numbers: &[TextToken<'_>],
    header: &Header,
    sections: &mut Sections,
) -> Result<(), FormatError> {
    let count = header.dimension.ok_or_else(|| {
        at.trouble(format!("{key} comes before DIMENSION"), "its length depends on it", "put DIMENSION into the head")
    })?;
    match key {
        "NODE_COORD_SECTION" => {
            let rows = numbered::<2>(at, numbers, count, "a coordinate")?;
            sections.places = Some(rows.into_iter().map(|[x, y]| (x, y)).collect());
        }
        "NODE_SCORE_SECTION" => {
            let rows = numbered::<1>(at, numbers, count, "a score")?;
            sections.scores = Some(rows.into_iter().map(|[score]| score).collect());
            let negative = numbers.chunks(2).filter_map(|row| row.get(1)).find(|word| word.text.starts_with('-'));
            negative.map_or(Ok(()), |word| word.amount("a score").map(|_| ()))?;
        }
        "EDGE_WEIGHT_SECTION" => sections.weights = Some(weights::read(at, numbers, count, header)?),
        "DEPOT_SECTION" => sections.depot = depot(at, numbers, count)?,
        "DISPLAY_DATA_SECTION" => {}
        _ => {
            let reason = "it would change the problem, and is not read";
            return Err(at.trouble(format!("{} is not known", words::cut(key)), reason, HELP));
        }
    }
    Ok(())
}

/// Returns rows of a node's number and `N` numbers, for each node from 1 to `count` in any order.
fn numbered<const N: usize>(
    at: &TextToken<'_>,
    numbers: &[TextToken<'_>],
    count: usize,
    what: &str,
) -> Result<Vec<[f64; N]>, FormatError> {
    let mut rows: Vec<Option<[f64; N]>> = vec![None; count];
    for row in numbers.chunks(N + 1) {
        let Some((node, values)) = row.split_first() else { continue };
        let node_number = node.count("the number of a node", count)?;
        let mut read = [0.0; N];
        for (index, slot) in read.iter_mut().enumerate() {
            let word = values.get(index);
            let short =
                || node.trouble(format!("node {node_number} has too few numbers"), format!("{N} follow it"), HELP);
            *slot = word.ok_or_else(short)?.number(what)?;
        }
        match node_number.checked_sub(1).and_then(|index| rows.get_mut(index)) {
            Some(slot @ None) => *slot = Some(read),
            Some(Some(_)) => {
                return Err(node.trouble(
                    format!("node {node_number} comes twice"),
                    "each has one row",
                    "leave one out",
                ));
            }
            None => return Err(node.trouble("there is no node 0", "nodes are numbered from 1", HELP)),
        }
    }
    let missing = rows.iter().position(Option::is_none);
    if let Some(missing) = missing {
        let reason = format!("{} of {count} nodes have one", rows.iter().flatten().count());
        let message = format!("node {} is missing in {}", missing + 1, words::cut(at.text));
        return Err(numbers.last().unwrap_or(at).trouble(message, reason, "add its row, or correct DIMENSION"));
    }
    Ok(rows.into_iter().flatten().collect())
}

/// Returns the index of the only depot; `None` if the section is empty.
fn depot(at: &TextToken<'_>, numbers: &[TextToken<'_>], count: usize) -> Result<Option<usize>, FormatError> {
    let mut listed = numbers.iter().take_while(|word| word.text != "-1");
    let Some(first) = listed.next() else { return Ok(None) };
    if let Some(second) = listed.next() {
        return Err(second.trouble("there is a second depot", "a tour begins and ends at one", "leave one out"));
    }
    let number = first.count("the number of the depot", count)?;
    let none = || at.trouble("there is no node 0", "nodes are numbered from 1", HELP);
    number.checked_sub(1).map(Some).ok_or_else(none)
}

fn finish(name: &str, text: &str, header: &Header, sections: Sections) -> Result<Instance, FormatError> {
    let missing = |what: &str| ends_early(text, format!("{what} is missing"), "without it there is no problem");
    let count = header.dimension.ok_or_else(|| missing("DIMENSION"))?;
    let question = header.question.ok_or_else(|| missing("TYPE"))?;
    let weights = match (header.metric, &sections.places, sections.weights) {
        (Some(Some(metric)), Some(places), _) => Weights::Places(metric, places.clone()),
        (Some(Some(_)), None, _) => return Err(missing("NODE_COORD_SECTION")),
        (Some(None), _, Some(matrix)) => Weights::Matrix(matrix),
        (Some(None), _, None) => return Err(missing("EDGE_WEIGHT_SECTION")),
        (None, _, _) => return Err(missing("EDGE_WEIGHT_TYPE")),
    };
    let depot = sections.depot.unwrap_or(0);
    // The depot comes first; the others keep their order and their numbers.
    let order: Vec<usize> = std::iter::once(depot).chain((0..count).filter(|node| *node != depot)).collect();
    let limit = match (question, header.limit) {
        (ProblemKind::Orienteering, None) => return Err(missing("COST_LIMIT")),
        (ProblemKind::Orienteering, Some(limit)) => limit,
        _ => weights.longest(count) * (count as f64 + 1.0) + 1.0,
    };
    if question == ProblemKind::Orienteering && sections.scores.is_none() {
        return Err(missing("NODE_SCORE_SECTION"));
    }
    let place = |node: usize| sections.places.as_ref().and_then(|places| places.get(node)).copied();
    let vertex = |node: &usize| {
        // Weights do not determine places: all nodes are then at one point.
        let (x, y) = place(*node).unwrap_or_default();
        let profit = sections.scores.as_ref().and_then(|scores| scores.get(*node)).copied().unwrap_or(1.0);
        // GEO names the latitude first.
        let (x, y) = if weights.is_geographical() { (y, x) } else { (x, y) };
        Vertex { name: (node + 1).to_string(), x, y, service: 0.0, profit, opens: 0.0, closes: limit }
    };
    let vertices: Vec<Vertex> = order.iter().map(vertex).collect();
    let resolution = if weights.are_whole() { 1.0 } else { 1e-6 };
    let frame = Frame { question, opens: 0.0, closes: limit, resolution, windows: false };
    let time = |from: usize, to: usize| match (order.get(from), order.get(to)) {
        (Some(from), Some(to)) => weights.between(*from, *to, count),
        _ => apex_model::problem::UNREACHABLE_S,
    };
    let problem = pose::problem(&vertices, frame, &time);
    let format = if question == ProblemKind::Orienteering { "OPLib" } else { "TSPLIB" };
    Ok(Instance {
        name: header.name.clone().unwrap_or_else(|| name.to_string()),
        format,
        question,
        vehicles: None,
        problem,
    })
}
