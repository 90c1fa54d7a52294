//! The frame of the page: style, contents, sections, script.

use super::svg;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// The colours of all pages: style sheet.
pub const PALETTE: &str = include_str!("palette.css");

/// A part of the page, or only its name if there is nothing for it.
pub struct Section {
    id: &'static str,
    title: &'static str,
    body: Option<Markup>,
}

impl Section {
    /// A section; `body` is asked for only if its inputs are there.
    pub fn new(id: &'static str, title: &'static str, there: bool, body: impl FnOnce() -> Markup) -> Self {
        Self { id, title, body: there.then(body) }
    }
}

/// The page. Its markup is well-formed XML too, so that a test can read it.
pub fn page(intro: &Markup, key_figures: &Markup, sections: &[Section]) -> Markup {
    let missing: Vec<&str> = sections.iter().filter(|s| s.body.is_none()).map(|s| s.title).collect();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                (PreEscaped("<meta charset=\"utf-8\"/><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/><meta name=\"color-scheme\" content=\"light dark\"/>"))
                title { "Tactus: results" }
                style { (PreEscaped(PALETTE)) (PreEscaped(include_str!("style.css"))) }
            }
            body {
                (svg::hatches())
                nav aria-label="Contents" {
                    p { "Contents" }
                    ol {
                        @for section in sections.iter().filter(|s| s.body.is_some()) {
                            li { a href={"#" (section.id)} { (section.title) } }
                        }
                    }
                }
                main {
                    header { (intro) (key_figures) }
                    @if !missing.is_empty() { p class="absent" { "Not in this directory: " (missing.join(", ").to_lowercase()) "." } }
                    @for section in sections {
                        @if let Some(body) = &section.body {
                            section id=(section.id) { h2 { (section.title) } (body) }
                        }
                    }
                }
                script { (PreEscaped(include_str!("script.js"))) }
            }
        }
    }
}
