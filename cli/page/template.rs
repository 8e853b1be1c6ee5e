//! The page's text: its template, filled in. Every value is escaped where it is written, but for the page's own style and script.

use super::view::Page;
use crate::job::MARK;
use crate::report::{Exit, Failure, Outcome};
use guard::text::html;
use minijinja::{Environment, Error, ErrorKind, UndefinedBehavior, Value, context};

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// uPlot 1.6.32 by Leon Sorokin, MIT: draws the plots.
const PLOT_SCRIPT: &str = include_str!("uPlot.iife.min.js");
const PLOT_STYLE: &str = include_str!("uPlot.min.css");
const PLOT_LICENSE: &str = include_str!("uPlot.LICENSE");

/// The text of a page with the data of its plots.
pub fn render(page: &Page, data: &serde_json::Value) -> Outcome<String> {
    let data = html::script(&data.to_string());
    let own = Value::from_safe_string;
    let style = format!("{PLOT_STYLE}\n{STYLE}");
    let script = format!("/*\nuPlot:\n{PLOT_LICENSE}*/\n{PLOT_SCRIPT}\n{SCRIPT}");
    let values = context! {
        page, mark => own(MARK.into()), style => own(style), script => own(script), data => own(data),
        version => env!("CARGO_PKG_VERSION"),
    };
    let mut environment = Environment::new();
    environment.set_trim_blocks(true);
    environment.set_lstrip_blocks(true);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_formatter(|out, _, value| {
        if value.is_undefined() || value.is_none() {
            return Err(Error::new(ErrorKind::UndefinedError, "a value that is not there"));
        }
        let text = value.to_string();
        out.write_str(&if value.is_safe() { text } else { html::text(&text) }).map_err(Error::from)
    });
    let text = environment.render_named_str("page.html", TEMPLATE, values);
    text.map_err(|e| Failure::new(Exit::Fault, format!("the page's template: {e:#}")))
}
