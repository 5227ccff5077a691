//! The `apex` command.
fn main() {}
