//! Solomon's text for vehicle routing with time windows, read as orienteering: the demand is the profit.
//!
//! ```text
//! NAME
//! VEHICLE / NUMBER CAPACITY / 25 200
//! CUSTOMER / CUST NO. XCOORD. YCOORD. DEMAND READY TIME DUE DATE SERVICE TIME
//! 0 35 35 0 0 230 0
//! ```
//! Distances are cut to 1 decimal; capacity plays no part.

use super::distance::Metric;
use super::instance::{Instance, ProblemKind};
use super::pose::{self, Frame, Vertex};
use super::toptw::{resolution, way};
use super::words::{self, TextToken, ends_early};
use crate::format_error::FormatError;

const HELP: &str = "docs/reference/planning-problems.md shows the format";
const FORM: &str = "a customer is `number x y demand ready due service`";

/// Returns true if a line `VEHICLE` is near the top.
pub(super) fn is_one(text: &str) -> bool {
    let mut lines = words::lines(text).filter(|line| !line.is_empty()).take(4);
    lines.any(|line| line.len() == 1 && line.first().is_some_and(|word| word.text.eq_ignore_ascii_case("VEHICLE")))
}

/// Reads a file.
pub(super) fn read(name: &str, text: &str) -> Result<Instance, FormatError> {
    let mut own_name = None;
    let mut vehicles = None;
    let mut vertices: Vec<Vertex> = Vec::new();
    let mut decimals = 1;
    let mut last = None;
    for line in words::lines(text) {
        let Some(first) = line.first().copied() else { continue };
        last = Some(first);
        let starts_with_number =
            first.text.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+' || c == '.');
        let is_title =
            ["VEHICLE", "NUMBER", "CUSTOMER", "CUST"].iter().any(|word| first.text.eq_ignore_ascii_case(word));
        if vehicles.is_none() && !is_title && !starts_with_number && own_name.is_none() {
            own_name = Some(first.text.to_string());
        } else if vehicles.is_none() && starts_with_number {
            vehicles = Some(first.count("the number of vehicles", 100_000)?);
        } else if starts_with_number {
            pose::check_count(vertices.len().max(1), &first)?;
            let (vertex, own) = customer(&line, vertices.len())?;
            decimals = decimals.max(own);
            vertices.push(vertex);
        } else if !is_title {
            let reason = "only NAME, VEHICLE, NUMBER CAPACITY, CUSTOMER, CUST NO. and lines of numbers are known";
            return Err(first.trouble(format!("{} is not known", words::cut(first.text)), reason, HELP));
        }
    }
    let last = last.filter(|_| vertices.len() > 1);
    let Some(last) = last else { return Err(ends_early(text, "there is no customer", FORM)) };
    pose::check_count(vertices.len() - 1, &last)?;
    let frame = Frame {
        question: ProblemKind::OrienteeringWithWindows,
        opens: vertices.first().map_or(0.0, |depot| depot.opens),
        closes: vertices.first().map_or(0.0, |depot| depot.closes),
        resolution: resolution(decimals),
        windows: true,
    };
    let problem = pose::problem(&vertices, frame, &|from, to| way(&vertices, Metric::EuclideanCut(1), from, to));
    let name = own_name.unwrap_or_else(|| name.to_string());
    let format = "Solomon, distances cut to 1 decimal, demand as profit";
    Ok(Instance { name, format, question: frame.question, vehicles, problem })
}

fn customer(line: &[TextToken<'_>], number: usize) -> Result<(Vertex, usize), FormatError> {
    let [id, x, y, demand, ready, due, service] = line else {
        let last = line.last().map(|last| last.trouble(format!("the line has {} numbers", line.len()), FORM, HELP));
        return Err(last.unwrap_or_else(|| ends_early("", "a customer is missing", FORM)));
    };
    if id.count("the number of the customer", 100_000)? != number {
        let reason = format!("customers are listed in order, and {number} is next");
        return Err(id.trouble(format!("customer {} is out of order", id.text), reason, "sort the lines"));
    }
    let vertex = Vertex {
        name: id.text.to_string(),
        x: x.number("x, a coordinate")?,
        y: y.number("y, a coordinate")?,
        profit: demand.amount("the demand, which is the profit")?,
        opens: ready.amount("the ready time")?,
        closes: due.amount("the due date")?,
        service: service.amount("the service time")?,
    };
    pose::check_window(&vertex, due)?;
    let decimals = [ready, due, service].iter().map(|word| word.decimals()).max().unwrap_or(0);
    Ok((vertex, decimals))
}
