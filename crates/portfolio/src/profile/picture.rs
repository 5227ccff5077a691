//! Heat maps of cells in the layout of Figure 4, as SVG: rows are scale, rate and cost, columns count and space.

use super::error::ProfileError;
use super::published::not_answered;
use super::verdict::{self, Verdict};
use super::{Profile, budget_words, published};
use crate::cell::Cell;
use std::fmt::Write;

/// Width and height of a square, in pixels.
const SQUARE: (usize, usize) = (26, 17);
/// Upper left corner of the squares in pixels, below titles and to the right of row labels.
const ORIGIN: (usize, usize) = (205, 72);
/// Space between two maps.
const GAP: usize = 18;
/// Columns of a map, and rows.
const SHAPE: (usize, usize) = (9, 27);
/// Colours, one per planner in the order of a profile; further planners repeat them.
const COLOURS: [&str; 6] = ["#bbbbbb", "#4477aa", "#ee6677", "#228833", "#ccbb44", "#aa3377"];
/// Colour of cells without a verdict.
const PALE: &str = "#f4f4f4";

/// One square: its colour, the strength of the colour, its text, and its tooltip.
#[derive(Clone, Debug, PartialEq)]
pub struct Square {
    fill: &'static str,
    strength: f64,
    text: String,
    hint: String,
}

/// One heat map.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    title: String,
    squares: Vec<(Cell, Square)>,
    legend: Vec<(&'static str, String)>,
}

/// Returns the map of the best planner of each cell at `budget` (an index): full colour if it is better than all others, weaker if others
/// do not differ from it, weakest and with a question mark if that is undecided.
pub fn best(profile: &Profile, budget: usize) -> Map {
    let name = |planner: usize| profile.planners.get(planner).map_or("", |known| known.name.as_str());
    let square = |best: &verdict::Best| {
        let (strength, mark) = match best.verdict {
            Verdict::First | Verdict::Second => (1.0, ""),
            Verdict::NoDifference => (0.5, "="),
            Verdict::Undecided => (0.25, "?"),
        };
        let effect = best.next.map_or(0.0, |(_, next)| 100.0 * (1.0 - libm::exp(next.effect)));
        let next = best.next.map_or("", |(next, _)| name(next));
        let hint = format!("{} {effect:.1} % before {next}", name(best.planner));
        let initial: String = name(best.planner).chars().take(1).collect();
        Square { fill: colour(best.planner), strength, text: format!("{initial}{mark}"), hint }
    };
    let units = profile.budgets.get(budget).copied().unwrap_or(0);
    let bests = verdict::best(profile, budget);
    let squares = profile.rows.iter().zip(&bests).map(|(row, best)| (row.cell, square(best)));
    let legend = profile.planners.iter().enumerate().map(|(at, planner)| (colour(at), planner.name.clone()));
    Map {
        title: format!("best planner at {}", budget_words(units)),
        squares: squares.collect(),
        legend: legend.collect(),
    }
}

/// Returns Figure 4 as published, and the same map (2-Opt or WAM) from `profile` at `budget` (an index).
pub fn beside_figure_4(profile: &Profile, budget: usize) -> Result<[Map; 2], ProfileError> {
    let [first, second] = published::PLANNERS.map(|name| profile.planner(name).ok_or_else(not_answered));
    let (first, second) = (first?, second?);
    let fills = [COLOURS[4], COLOURS[1], COLOURS[2], COLOURS[0]];
    let fill = |code: usize| fills.get(code).copied().unwrap_or(PALE);
    let word = |code: usize| published::LEGEND.get(code).copied().unwrap_or("undecided");
    let legend: Vec<(&'static str, String)> = (0..4)
        .map(|code| (fill(code), format!("{code} {}", word(code))))
        .chain([(PALE, "? undecided".into())])
        .collect();
    let square = |code: Option<usize>, effect: Option<f64>| {
        let (fill, text) = code.map_or((PALE, "?".to_string()), |code| (fill(code), code.to_string()));
        let hint = effect.map_or_else(
            || word(code.unwrap_or(4)).to_string(),
            |effect| {
                format!(
                    "{}; 2-Opt costs {:+.1} % against WAM",
                    word(code.unwrap_or(4)),
                    100.0 * (libm::exp(effect) - 1.0)
                )
            },
        );
        Square { fill, strength: 1.0, text, hint }
    };
    let theirs = published::codes().into_iter().map(|(cell, code)| (cell, square(Some(code), None))).collect();
    let compared = verdict::pair(profile, budget, first, second);
    let ours = profile.rows.iter().zip(&compared);
    let ours = ours.map(|(row, one)| (row.cell, square(published::code(one), Some(one.effect)))).collect();
    let units = profile.budgets.get(budget).copied().unwrap_or(0);
    let title = format!("ours at {}: 2-Opt or WAM", budget_words(units));
    Ok([
        Map { title: "Figure 4 as published".into(), squares: theirs, legend: legend.clone() },
        Map { title, squares: ours, legend },
    ])
}

fn colour(planner: usize) -> &'static str {
    COLOURS.get(planner % COLOURS.len()).copied().unwrap_or(PALE)
}

/// Returns an SVG drawing of maps side by side, with the legend of the first one.
pub fn svg(maps: &[Map]) -> String {
    let width = ORIGIN.0 + maps.len() * (SHAPE.0 * SQUARE.0 + GAP);
    let height = ORIGIN.1 + SHAPE.1 * SQUARE.1 + 40;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    // Writing to a string cannot fail.
    let _ = rows(&mut out);
    for (index, map) in maps.iter().enumerate() {
        let left = ORIGIN.0 + index * (SHAPE.0 * SQUARE.0 + GAP);
        let _ = columns(&mut out, left, &map.title);
        let _ = map.squares.iter().try_for_each(|(cell, square)| draw(&mut out, left, *cell, square));
    }
    let _ = legend(&mut out, maps.first().map_or(&[], |map| map.legend.as_slice()), height - 22);
    out.push_str("</svg>\n");
    out
}

/// Writes the row labels, each where it changes.
fn rows(out: &mut String) -> std::fmt::Result {
    for row in 0..SHAPE.1 {
        let Some(cell) = Cell::all().get(row * SHAPE.0).copied() else { continue };
        let y = ORIGIN.1 + row * SQUARE.1 + 12;
        for (x, every, word) in [(6, 9, cell.scale.word()), (70, 3, cell.rate.word()), (138, 1, cell.cost.word())] {
            if row.is_multiple_of(every) {
                writeln!(out, "<text x=\"{x}\" y=\"{y}\">{word}</text>")?;
            }
        }
    }
    let heads = [(6, "scale"), (70, "rate"), (138, "cost")];
    heads.into_iter().try_for_each(|(x, word)| {
        writeln!(out, "<text x=\"{x}\" y=\"{}\" font-weight=\"bold\">{word}</text>", ORIGIN.1 - 6)
    })
}

/// Writes title, counts and spaces of one map.
fn columns(out: &mut String, left: usize, title: &str) -> std::fmt::Result {
    writeln!(out, "<text x=\"{left}\" y=\"18\" font-weight=\"bold\">{}</text>", escaped(title))?;
    for column in 0..SHAPE.0 {
        let Some(cell) = Cell::all().get(column).copied() else { continue };
        let x = left + column * SQUARE.0;
        if column.is_multiple_of(3) {
            writeln!(out, "<text x=\"{x}\" y=\"40\">{} targets</text>", cell.count)?;
        }
        let [.., (_, space)] = cell.words();
        let short: String = space.chars().take(4).collect();
        writeln!(out, "<text x=\"{x}\" y=\"{}\" font-size=\"9\">{short}</text>", ORIGIN.1 - 8)?;
    }
    Ok(())
}

fn draw(out: &mut String, left: usize, cell: Cell, square: &Square) -> std::fmt::Result {
    // Cells with a count that the grid lacks have no place in the map.
    let Some(place) = Cell::all().iter().position(|known| *known == cell) else { return Ok(()) };
    let (x, y) = (left + place % SHAPE.0 * SQUARE.0, ORIGIN.1 + place / SHAPE.0 * SQUARE.1);
    let Square { fill, strength, text, hint } = square;
    let (width, height) = (SQUARE.0 - 1, SQUARE.1 - 1);
    writeln!(
        out,
        "<g><title>{cell}: {}</title><rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"{fill}\" \
         fill-opacity=\"{strength}\"/><text x=\"{}\" y=\"{}\" font-size=\"10\" text-anchor=\"middle\">{}</text></g>",
        escaped(hint),
        x + width / 2,
        y + 12,
        escaped(text)
    )
}

fn legend(out: &mut String, entries: &[(&'static str, String)], y: usize) -> std::fmt::Result {
    let mut x = ORIGIN.0;
    for (fill, words) in entries {
        writeln!(out, "<rect x=\"{x}\" y=\"{y}\" width=\"14\" height=\"12\" fill=\"{fill}\" stroke=\"#999999\"/>")?;
        writeln!(out, "<text x=\"{}\" y=\"{}\">{}</text>", x + 18, y + 10, escaped(words))?;
        x += 40 + 7 * words.len();
    }
    Ok(())
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
