//! `:lost-link`: when a link counts as lost, and the response of the flight (paper, section IV, example 2).
//!
//! The times and levels are PDL constants of the library `lost-link-figures`, whose shipped text has the defaults. The situation
//! determines the response without an instruction, and the end of the contingency route, when a link is lost.

use crate::error::MissionResult;
use crate::link_form::{LinkForm, PlaceOf};
use apex_model::library::Library;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_pdl::SourceText;
use std::fmt::Write;

/// The library of constants that the setting defines.
pub(crate) const FIGURES_LIBRARY: &str = "lost-link-figures";
const FIGURES_NAME: &str = "generated/lost-link-figures.pdl";
const SHIPPED_FIGURES_NAME: &str = "library/lost-link-figures.pdl";
const TIME_S_MAX: f64 = 86_400.0;
const LOSSES_MAX: f64 = 100.0;
const USAGE: &str = "`:lost-link (:nominal 0.2 :good 0.3 :weak-for 20s :good-for 10s :regain-within 10min :instructions-within 2min \
                     :default resume :losses-max 5 :contingency PLACE)`, each optional";

/// Response of the flight if no instruction arrives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LostDefault {
    /// Plan again around the weak link and continue.
    Resume,
    /// Fly the contingency route.
    GoHome,
}

impl LostDefault {
    /// Returns the word in PDL.
    pub fn word(self) -> &'static str {
        match self {
            LostDefault::Resume => "resume",
            LostDefault::GoHome => "go-home",
        }
    }
}

/// Figures of lost links.
#[derive(Debug, Clone, PartialEq)]
pub struct LostLink {
    /// Below this level a link is weak, 0 to 1.
    pub nominal: f64,
    /// Level from which on the link is good; above `nominal`.
    pub good: f64,
    /// A link that is weak for longer than this is lost, s.
    pub weak_for_s: f64,
    /// Time in seconds for which a link must be good before its place counts as good.
    pub good_for_s: f64,
    /// Time for which the aircraft waits for the link at the last good place, s.
    pub regain_within_s: f64,
    /// Time in seconds for which the flight then waits for instructions.
    pub instructions_within_s: f64,
    /// Response without an instruction.
    pub default: LostDefault,
    /// Number of losses from which on the vehicle flies the contingency route without waiting.
    pub losses_max: u32,
    /// End of the contingency route; `None` for the nearest landing place whose link is not known to be weak.
    pub contingency: Option<Value>,
}

impl Default for LostLink {
    fn default() -> LostLink {
        LostLink {
            nominal: 0.2,
            good: 0.3,
            weak_for_s: 20.0,
            good_for_s: 10.0,
            regain_within_s: 600.0,
            instructions_within_s: 120.0,
            default: LostDefault::Resume,
            losses_max: 5,
            contingency: None,
        }
    }
}

impl LostLink {
    /// Returns the mean level above which a place is suitable for a return: as far above `good` as that is above `nominal`, so that
    /// fading does not lose the link again; at most halfway to full level.
    pub(crate) fn known_good(&self) -> f64 {
        (2.0 * self.good - self.nominal).min(0.5 * (1.0 + self.good))
    }
}

/// Reads the figures of the items of `:lost-link`; `at` is the place of the application. Without `place_of` the place of `:contingency`
/// is not resolved.
///
/// # Errors
/// A key that is unknown or repeated, a figure of another type or outside of its range, `:good` not above `:nominal`, or a place that the
/// mission does not have.
pub(crate) fn read((items, at): (&[Value], &str), place_of: Option<PlaceOf<'_>>) -> MissionResult<LostLink> {
    let whole = Value::list(items.iter().cloned());
    let form =
        LinkForm { at, option: "lost-link", form: &whole, usage: USAGE, place_of: place_of.unwrap_or(&|_| None) };
    let mut figures = LostLink::default();
    let mut good = None;
    for (key, value) in form.pairs(items)? {
        let time = |most: f64| form.figure(key, value, Dimension::TIME, most);
        match key {
            ":nominal" => figures.nominal = form.share(key, value)?,
            ":good" => good = Some(form.share(key, value)?),
            ":weak-for" => figures.weak_for_s = time(TIME_S_MAX)?,
            ":good-for" => figures.good_for_s = time(TIME_S_MAX)?,
            ":regain-within" => figures.regain_within_s = time(TIME_S_MAX)?,
            ":instructions-within" => figures.instructions_within_s = time(TIME_S_MAX)?,
            ":default" => {
                let words = [LostDefault::Resume, LostDefault::GoHome];
                let found = words.into_iter().find(|word| value.as_symbol().is_some_and(|said| said.is(word.word())));
                figures.default =
                    found.ok_or_else(|| form.wrong(format!("`:default {value}` is not resume or go-home")))?;
            }
            ":losses-max" => {
                let losses = form.figure(key, value, Dimension::NONE, LOSSES_MAX)?;
                if losses.fract() != 0.0 {
                    return Err(form.wrong(format!("`:losses-max {value}` is not a whole number")));
                }
                figures.losses_max = losses as u32;
            }
            ":contingency" => {
                if place_of.is_some() {
                    form.place(key, value)?;
                }
                figures.contingency = Some(value.clone());
            }
            other => {
                let known = ":nominal, :good, :weak-for, :good-for, :regain-within, :instructions-within, :default, :losses-max, :contingency";
                return Err(form.unknown(other, known));
            }
        }
    }
    if figures.nominal <= 0.0 {
        return Err(form.wrong("`:nominal 0` never finds a link weak: expected a level above 0".to_string()));
    }
    figures.good = good.unwrap_or_else(|| (figures.nominal + 0.1).min(1.0));
    if figures.good <= figures.nominal {
        let (good, nominal) = (figures.good, figures.nominal);
        return Err(form.wrong(format!("`:good {good}` is not above the nominal level {nominal}")));
    }
    Ok(figures)
}

/// Returns the text that replaces the library of figures in a program; `None` if the program does not use that library, or states only
/// the shipped figures. Errors of the setting are reported when the mission is loaded.
pub(crate) fn figures_for(library: &Library) -> Option<SourceText> {
    let shipped = library.sources.iter().find(|source| &*source.name == SHIPPED_FIGURES_NAME)?;
    let items = library.application.as_ref()?.option("lost-link")?.as_list()?;
    let text = figures(&read((items, ""), None).ok()?);
    (text != *shipped.text).then(|| SourceText { name: FIGURES_NAME.to_string(), text })
}

/// Returns the figures as a library of PDL.
fn figures(lost: &LostLink) -> String {
    let constants = [
        ("nominal", lost.nominal, ""),
        ("good", lost.good, ""),
        ("weak-for", lost.weak_for_s, "s"),
        ("good-for", lost.good_for_s, "s"),
        ("regain-within", lost.regain_within_s, "s"),
        ("instructions-within", lost.instructions_within_s, "s"),
    ];
    let mut text = ";;; Figures of lost links. What a mission states as `:lost-link` replaces this text; these are the defaults. Generated:\n\
                    ;;; docs/reference/mission-data.md describes each.\n\n\
                    (in-apex-bundle :lost-link-figures)\n\n"
        .to_string();
    for (name, value, unit) in constants {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "(defconstant +lost-link-{name}+ {value}{unit})");
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;
    use std::path::Path;

    #[test]
    fn the_shipped_figures_are_the_defaults() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(SHIPPED_FIGURES_NAME);
        assert_eq!(crate::files::read_text(&path).unwrap(), figures(&LostLink::default()));
    }
}
