//! The reference page of the libraries equals the one made from their text. UPDATE=1 writes it.

#![allow(clippy::expect_used, reason = "a test that cannot continue fails")]

use apex_pdl::library_reference;

#[test]
fn the_page_of_the_libraries_is_of_their_text() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/reference/library.md");
    let page = library_reference();
    if std::env::var("UPDATE").is_ok_and(|update| update == "1") {
        std::fs::write(path, &page).expect("the page can be written");
    }
    let written = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        written == page,
        "docs/reference/library.md is not of this text: UPDATE=1 cargo test -p apex-pdl --test library_page"
    );
}
