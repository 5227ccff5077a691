//! Clouds as forecast by the mission: decks with a cover, by area, altitude and time.
//!
//! Bound: O(decks) per query.

use crate::error::MissionResult;
use crate::sources::DataFile;
use crate::surroundings::{area_of, hours_of};
use crate::tables;
use apex_model::problem::{Area, Position, TimeWindow};

const COLUMNS: &[&str] = &["base_m", "top_m", "cover"];
const COLUMNS_OPTIONAL: &[&str] = &["south_deg", "north_deg", "west_deg", "east_deg", "from_h", "until_h"];

/// One deck of clouds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudDeck {
    /// The area of the deck; `None` for everywhere.
    pub area: Option<Area>,
    /// Lower side above mean sea level.
    pub base_m: f64,
    /// Upper side above mean sea level.
    pub top_m: f64,
    /// Time of the deck.
    pub active: TimeWindow,
    /// Share of the sky that the deck covers, 0 to 1.
    pub cover: f64,
}

impl CloudDeck {
    /// Returns true if a place in the air may be inside of the deck.
    pub(crate) fn contains(&self, position: Position, altitude_m: f64, time_s: f64) -> bool {
        (self.base_m..=self.top_m).contains(&altitude_m)
            && self.cover > 0.0
            && self.active.contains(time_s)
            && self.area.is_none_or(|area| area.contains(position))
    }
}

/// Reads a forecast of clouds.
///
/// # Errors
/// As docs/reference/mission-data.md lists them.
pub(crate) fn read(file: &DataFile) -> MissionResult<Vec<CloudDeck>> {
    tables::read(file, COLUMNS, COLUMNS_OPTIONAL)?.rows().map(|row| deck(&row)).collect()
}

fn deck(row: &tables::TableRow<'_>) -> MissionResult<CloudDeck> {
    let (from_s, until_s) = hours_of(row)?;
    let deck = CloudDeck {
        area: area_of(row)?,
        base_m: row.required("base_m", -500.0, 30_000.0)?,
        top_m: row.required("top_m", -500.0, 30_000.0)?,
        active: TimeWindow { from_s, until_s },
        cover: row.required("cover", 0.0, 1.0)?,
    };
    if deck.top_m <= deck.base_m {
        return Err(row
            .trouble(format!("the deck's top ({} m) is not above its base ({} m)", deck.top_m, deck.base_m))
            .help("give both above mean sea level"));
    }
    if until_s <= from_s {
        return Err(row.trouble("the deck ends before it begins"));
    }
    Ok(deck)
}

/// Returns the share of the vertical lines of sight between a position in the air and the ground that is free of cloud: the product over
/// the decks whose base is below.
pub(crate) fn clear_share(decks: &[CloudDeck], position: Position, altitude_m: f64, time_s: f64) -> f64 {
    let below = decks.iter().filter(|deck| {
        altitude_m > deck.base_m && deck.active.contains(time_s) && deck.area.is_none_or(|area| area.contains(position))
    });
    below.fold(1.0, |clear, deck| clear * (1.0 - deck.cover))
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::FOREVER_S;

    const HERE: Position = Position::new(44.0, -115.0);

    fn file(text: &str) -> DataFile {
        DataFile { place: "clouds.csv".to_string(), bytes: text.as_bytes().to_vec() }
    }

    #[test]
    fn decks_hide_the_ground_from_above_their_base() {
        let decks = read(&file("base_m,top_m,cover,from_h,until_h\n3000,4000,0.4,,\n5000,6000,0.5,1,2\n")).unwrap();
        let clear = |altitude_m: f64, time_s: f64| clear_share(&decks, HERE, altitude_m, time_s);
        assert_eq!([clear(2_900.0, 0.0), clear(7_000.0, 0.0)], [1.0, 0.6]);
        assert!((clear(7_000.0, 5_000.0) - 0.3).abs() < 1e-12);
        assert_eq!(decks[0].active.until_s, FOREVER_S);
    }

    #[test]
    fn a_deck_of_an_area_is_nowhere_else() {
        let text = "south_deg,north_deg,west_deg,east_deg,base_m,top_m,cover\n43,45,-116,-114,3000,4000,1\n";
        let decks = read(&file(text)).unwrap();
        assert_eq!(clear_share(&decks, HERE, 7_000.0, 0.0), 0.0);
        assert_eq!(clear_share(&decks, Position::new(46.0, -115.0), 7_000.0, 0.0), 1.0);
    }

    #[test]
    fn impossible_decks_are_refused_with_their_line() {
        let refused = |row: &str| read(&file(&format!("base_m,top_m,cover\n{row}\n"))).unwrap_err().to_string();
        assert!(refused("4000,3000,0.5").contains("clouds.csv:2"), "{}", refused("4000,3000,0.5"));
        assert!(refused("3000,4000,1.5").contains("`cover` is 1.5"));
        assert!(refused("3000,4000,").contains("`cover` is empty"));
    }
}
