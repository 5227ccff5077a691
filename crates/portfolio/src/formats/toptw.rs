//! TOPTW text: the format in which the team orienteering problem with time windows is exchanged.
//!
//! ```text
//! k v N t          v: number of paths that suffice for all; N: number of vertices in addition to the depot
//! D Q              not relevant
//! i x y d S f a list O C      N + 1 lines; i = 0 is the depot; d service time, S profit, O opening, C closing
//! ```
//! `list` has `a` numbers of no meaning here. Lines that begin with `*` are comments. Distances are cut to 2 decimals where a
//! coordinate has decimals (Cordeau), else to 1 (Solomon).

use super::distance::Metric;
use super::instance::{Instance, ProblemKind};
use super::pose::{self, Frame, Vertex};
use super::words::{self, TextToken, ends_early};
use crate::format_error::FormatError;

/// Maximum number of paths that a file may name.
const VEHICLES_MAX: usize = 100_000;
/// Numbers of a vertex before the list of `a` numbers.
const BEFORE_LIST: usize = 7;

/// Returns true if `text` begins with a line of numbers.
pub(super) fn is_one(text: &str) -> bool {
    let first = content(text).next();
    first.is_some_and(|line| line.len() >= 3 && line.iter().take(3).all(|word| word.text.parse::<f64>().is_ok()))
}

fn content(text: &str) -> impl Iterator<Item = Vec<TextToken<'_>>> {
    words::lines(text).filter(|line| line.first().is_some_and(|word| !word.text.starts_with('*')))
}

/// Reads a file.
pub(super) fn read(name: &str, text: &str) -> Result<Instance, FormatError> {
    let mut lines = content(text);
    let head = lines.next().ok_or_else(|| ends_early(text, "the file is empty", "its first line is `k v N t`"))?;
    let (Some(first), Some(vehicles), Some(count)) = (head.first(), head.get(1), head.get(2)) else {
        return Err(head.last().map_or_else(
            || ends_early(text, "the file is empty", "its first line is `k v N t`"),
            |last| last.trouble("the first line is too short", "it is `k v N t`", HELP),
        ));
    };
    first.number("k, the kind of problem")?;
    let vehicles = vehicles.count("v, the number of paths", VEHICLES_MAX)?;
    let wanted = count.count("N, the number of vertices other than the depot", usize::MAX >> 12)?;
    pose::check_count(wanted, count)?;
    if lines.next().is_none() {
        return Err(ends_early(text, "the second line is missing", "it is `D Q` (two numbers, which are ignored)"));
    }
    let mut vertices = Vec::with_capacity(wanted + 1);
    let (mut of_places, mut of_times) = (0, 0);
    for number in 0..=wanted {
        let missing = || {
            let message = format!("there are {number} vertices, and {} are announced", wanted + 1);
            ends_early(text, message, "N counts the vertices other than the depot")
        };
        let line = lines.next().ok_or_else(missing)?;
        let (vertex, decimals) = vertex(&line, number)?;
        of_places = of_places.max(decimals.0);
        of_times = of_times.max(decimals.1);
        vertices.push(vertex);
    }
    if let Some(more) = lines.next().and_then(|line| line.first().copied()) {
        let announced = format!("the header states {} vertices including the depot", wanted + 1);
        return Err(more.trouble("there are more vertices than announced", announced, HELP));
    }
    let cut: u8 = if of_places > 0 { 2 } else { 1 };
    let format = if cut == 2 { "TOPTW, distances cut to 2 decimals" } else { "TOPTW, distances cut to 1 decimal" };
    let frame = Frame {
        question: ProblemKind::OrienteeringWithWindows,
        opens: vertices.first().map_or(0.0, |depot| depot.opens),
        closes: vertices.first().map_or(0.0, |depot| depot.closes),
        resolution: resolution(of_times.max(usize::from(cut))),
        windows: true,
    };
    let metric = Metric::EuclideanCut(cut);
    let problem = pose::problem(&vertices, frame, &|from, to| way(&vertices, metric, from, to));
    let name = name.to_string();
    Ok(Instance { name, format, question: frame.question, vehicles: Some(vehicles), problem })
}

const HELP: &str = "docs/reference/planning-problems.md shows the format";

/// Returns the distance from one vertex to another.
pub(super) fn way(vertices: &[Vertex], metric: Metric, from: usize, to: usize) -> f64 {
    match (vertices.get(from), vertices.get(to)) {
        (Some(from), Some(to)) => metric.between((from.x, from.y), (to.x, to.y)),
        _ => apex_model::problem::UNREACHABLE_S,
    }
}

/// Returns the unit of the last of `decimals` decimals.
pub(super) fn resolution(decimals: usize) -> f64 {
    (0..decimals).fold(1.0, |unit, _| unit / 10.0)
}

/// Returns a vertex, with the decimals of its coordinates and of its times.
fn vertex(line: &[TextToken<'_>], number: usize) -> Result<(Vertex, (usize, usize)), FormatError> {
    let short = |last: &TextToken<'_>| {
        let form = "a vertex is `i x y d S f a list O C` with `a` numbers in the list";
        last.trouble(format!("the line has {} numbers", line.len()), form, HELP)
    };
    let [id, x, y, service, profit, _, lists, ..] = line else {
        return Err(line.last().map_or_else(|| ends_early("", "a vertex is missing", ""), short));
    };
    if id.count("i, the number of the vertex", VEHICLES_MAX)? != number {
        let reason = format!("vertices are listed in order, and {number} is next");
        return Err(id.trouble(format!("vertex {} is out of order", id.text), reason, "sort the lines"));
    }
    // Depots have no list, and some files contain none at all: opening and closing are the last two numbers.
    let lists = lists.count("a, the length of the list", VEHICLES_MAX)?;
    let wanted = [BEFORE_LIST + lists + 2, BEFORE_LIST + 2, BEFORE_LIST + 1];
    let depot = number == 0 && line.len() == BEFORE_LIST + 1;
    if !wanted.get(..2).is_some_and(|wanted| wanted.contains(&line.len())) && !depot {
        return Err(short(line.last().unwrap_or(id)));
    }
    let (opens, closes) = match line {
        [.., opens, closes] => (opens, closes),
        _ => return Err(short(id)),
    };
    let vertex = Vertex {
        name: id.text.to_string(),
        x: x.number("x, a coordinate")?,
        y: y.number("y, a coordinate")?,
        service: service.amount("d, the service time")?,
        profit: profit.amount("S, the profit")?,
        opens: opens.amount("O, the opening time")?,
        closes: closes.amount("C, the closing time")?,
    };
    pose::check_window(&vertex, closes)?;
    let decimals = |words: &[&TextToken<'_>]| words.iter().map(|word| word.decimals()).max().unwrap_or(0);
    Ok((vertex, (decimals(&[x, y]), decimals(&[service, opens, closes]))))
}
