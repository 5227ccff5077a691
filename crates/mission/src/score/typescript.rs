//! The page's TypeScript types of what was seen and scored. `UPDATE=1 cargo test -p apex-mission typescript` rewrites them.

use super::{Footprints, ScoreSoFar, SeenLine, SeenPicture, Swath};
use apex_typescript::{check, declaration};

#[test]
fn typescript_types_of_what_was_seen_are_current() {
    let declarations = [
        declaration::<SeenLine>(),
        declaration::<Swath>(),
        declaration::<SeenPicture>(),
        declaration::<Footprints>(),
        declaration::<ScoreSoFar>(),
    ];
    check("mission", "seen.ts", "", &declarations).unwrap();
}
