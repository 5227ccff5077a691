//! Creates the folder of the built web page if it is missing, so that the crate builds without the page, and rebuilds the crate when the
//! page changes.

use std::path::Path;

fn main() {
    let pages = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../web/dist");
    // A read-only source tree is no reason to fail: the embedding accepts a missing folder too.
    let _ = std::fs::create_dir_all(&pages);
    println!("cargo:rerun-if-changed=../../web/dist");
}
