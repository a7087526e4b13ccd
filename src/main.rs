//! The `oxplow` command.
fn main() {}
