//! The directives of scenes, comments `#scree …`: those that there are.

use ri::Fail;

/// What is left of settings that no directive has placed yet.
pub const OVERRIDES: [&str; 5] = ["Format", "Display", "PixelSamples", "PixelFilter", "ShadingRate"];

/// What scenes ask to be injected.
const INJECTIONS: [&str; 6] = ["camera", "lights", "objects", "floor", "pebbles", "levels"];

/// What is said of a directive that nobody knows.
pub fn unknown(directive: &str) -> Fail {
    let mut words = directive.split_whitespace();
    let (what, known) = match (words.next(), words.next().unwrap_or("")) {
        (Some("override"), what) => (format!("override {what}"), format!("one of {}", OVERRIDES.join(", "))),
        (Some("inject"), what) => {
            (format!("inject {what}"), "camera, lights, objects, floor, pebbles or levels".into())
        }
        _ => (directive.into(), "`inject`, `override`, `ground`, `floor`, `unit` or `decade`".into()),
    };
    Fail::new(format!("`#scree {what}` is unknown, expected {known}"))
}

/// Take a directive of a scene that is read without a binding, where it changes nothing; whether it asks for something to be injected. An
/// error if nobody knows it.
pub fn take_alone(directive: &str) -> Result<bool, Fail> {
    let mut words = directive.split_whitespace();
    match (words.next(), words.next()) {
        (Some("inject"), Some(what)) if INJECTIONS.contains(&what) => Ok(true),
        (Some("override"), Some(what)) if OVERRIDES.contains(&what) => Ok(false),
        (Some("ground" | "floor" | "unit" | "decade"), None) => Ok(false),
        _ => Err(unknown(directive)),
    }
}
