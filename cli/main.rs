//! The scree command.
fn main() {}
