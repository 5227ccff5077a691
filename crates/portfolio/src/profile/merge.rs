//! Merges profiles: parts that were measured separately, perhaps on other machines, become the profile that one machine would have
//! measured. Nothing is measured or chosen here; contradictory or missing contents are an error.

use super::{Planner, Profile, Row};
use crate::cell::Cell;

/// Returns the whole of `parts`, each with its name for operators.
///
/// Cells are in the order of [`Cell::all`], others after them in the order of the parts; the same holds for planners. Contents that two
/// parts share must be equal.
///
/// # Errors
/// An error message that names the part: its missions, budgets or versions differ from those of the first part, its costs contradict
/// another part, or a planner was not measured in all cells.
pub fn merged(parts: &[(String, Profile)]) -> Result<Profile, String> {
    let Some((first_name, first)) = parts.first() else { return Err("there are no parts".to_string()) };
    let mut whole = Profile { planners: Vec::new(), rows: Vec::new(), ..first.clone() };
    for (name, part) in parts {
        alike(part, first).map_err(|other| format!("{name} has other {other} than {first_name}"))?;
        for planner in &part.planners {
            match whole.planners.iter().find(|known| known.name == planner.name) {
                None => whole.planners.push(planner.clone()),
                Some(known) if known == planner => {}
                Some(known) => {
                    let Planner { name: planner, version } = planner;
                    return Err(format!("{name} has {planner} {version}, an earlier part has {}", known.version));
                }
            }
        }
    }
    let mut rows: Vec<Row> = Vec::new();
    for (name, part) in parts {
        for row in &part.rows {
            let place = rows.iter().position(|known| known.cell == row.cell).unwrap_or(rows.len());
            if place == rows.len() {
                rows.push(Row { costs: vec![Vec::new(); whole.planners.len()], ..row.clone() });
            }
            let Some(known) = rows.get_mut(place) else { continue };
            put(known, row, (part, &whole)).map_err(|why| format!("{name}: {why}"))?;
        }
    }
    let order = Cell::all();
    rows.sort_by_key(|row| order.iter().position(|cell| *cell == row.cell).unwrap_or(order.len()));
    for row in &rows {
        let missing = whole.planners.iter().zip(&row.costs).find(|(_, costs)| costs.is_empty());
        if let Some((planner, _)) = missing {
            return Err(format!("{} was not measured in {}", planner.name, row.cell));
        }
    }
    whole.rows = rows;
    Ok(whole)
}

/// Compares the properties of `part` and `first` that all parts must share.
fn alike(part: &Profile, first: &Profile) -> Result<(), &'static str> {
    if part.generator != first.generator {
        return Err("missions (by version of their generator)");
    }
    if part.missions != first.missions {
        return Err("numbers of missions");
    }
    if part.budgets != first.budgets {
        return Err("budgets");
    }
    Ok(())
}

/// Puts the costs of `row`, of `part`, into the row of the whole.
fn put(known: &mut Row, row: &Row, (part, whole): (&Profile, &Profile)) -> Result<(), String> {
    if known.hash != row.hash {
        return Err(format!("the missions of {} differ from those in an earlier part", row.cell));
    }
    for (planner, costs) in part.planners.iter().zip(&row.costs) {
        let place = whole.planner(&planner.name);
        let Some(slot) = place.and_then(|place| known.costs.get_mut(place)) else { continue };
        if !slot.is_empty() && slot != costs {
            return Err(format!("the costs of {} in {} differ from those in an earlier part", planner.name, row.cell));
        }
        slot.clone_from(costs);
    }
    Ok(())
}
