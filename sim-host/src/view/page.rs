//! The page around a run's payload: heading, places for the script to draw in, style, script.

use super::payload::Payload;
use crate::report::html::PALETTE;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// The script, made of `sim-host/view/` by `cargo xtask page`.
const SCRIPT: &str = include_str!("page.js");
const STYLE: &str = include_str!("style.css");

/// What stands above the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Heading {
    /// Title of the page.
    pub title: String,
    /// Names and values.
    pub facts: Vec<(String, String)>,
    /// A warning, such as that the recording is cut off.
    pub warning: Option<String>,
}

/// A button with a name for all who do not see it, and the key that does the same.
fn button(id: &str, face: &str, name: &str, key: &str) -> Markup {
    html! {
        button type="button" id=(id) aria-label=(name) title={ (name) " (" (key) ")" } aria-keyshortcuts=(key) { (face) }
    }
}

/// The keys and what they do.
const KEYS: [(&str, &str); 12] = [
    ("Space", "play, pause"),
    ("← →", "0.1 s back, on; with Shift 1 s"),
    ("Home End", "to the begin, to the end"),
    ("P N", "to the previous, next thing that happened"),
    ("+ −", "faster, slower"),
    ("1 2 3", "view of all, of the hand, from above"),
    ("F", "the view follows the hand, or stays"),
    ("W A S D", "turn the view"),
    ("E Q", "nearer, farther"),
    ("T", "light, dark"),
    ("?", "this list"),
    ("Esc", "closes it"),
];

fn header(heading: &Heading) -> Markup {
    html! {
        header {
            h1 { (heading.title) }
            dl { @for (name, value) in &heading.facts { div { dt { (name) } dd { (value) } } } }
            @if let Some(warning) = &heading.warning { p class="warning" role="alert" { (warning) } }
            span class="buttons" {
                (button("view-all", "All", "View of all", "1"))
                (button("view-hand", "Hand", "View of the hand", "2"))
                (button("view-top", "Top", "View from above", "3"))
                button type="button" id="follow" aria-pressed="false" aria-label="The view follows the hand" title="The view follows the hand (F)" { "Follow" }
                (button("theme", "◐", "Light or dark", "T"))
                (button("help", "?", "Keys", "?"))
            }
        }
    }
}

fn legend() -> Markup {
    let entry = |class: &str, text: &str| html! { li { i class=(class) {} (text) } };
    html! {
        ul id="legend" aria-label="Legend" {
            (entry("truth", "object, truth"))
            (entry("belief", "object, belief"))
            (entry("ellipse", "belief, 99 % of place and of yaw"))
            (entry("force", "contact force on the hand, 10 mm a newton"))
            (entry("pressure", "pad pressure"))
        }
    }
}

fn player() -> Markup {
    html! {
        footer {
            div class="buttons" {
                (button("previous", "|◀", "Previous thing that happened", "P"))
                (button("play", "▶", "Play", "Space"))
                (button("next", "▶|", "Next thing that happened", "N"))
                label { "speed " select id="speed" aria-label="Speed" {
                    @for speed in ["0.1", "0.25", "0.5", "1", "2", "5", "10"] {
                        option value=(speed) selected[speed == "1"] { (speed) " ×" }
                    }
                } }
                output id="clock" for="timeline" { "0.00 s" }
                span id="happened" {}
            }
            div id="timeline" role="slider" tabindex="0" aria-label="Time" aria-valuemin="0" {}
        }
    }
}

/// The page; it loads nothing.
///
/// # Errors
/// The payload cannot be written as JSON.
pub fn page(heading: &Heading, payload: &Payload) -> anyhow::Result<String> {
    // No `<` is left in it, so no tag can end it.
    let json = serde_json::to_string(payload)?.replace('<', "\\u003c");
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (heading.title) }
                style { (PreEscaped(PALETTE)) (PreEscaped(STYLE)) }
            }
            body {
                (header(heading))
                main {
                    section id="stage" aria-label="Arm, hand and objects" {
                        canvas id="canvas" tabindex="0" aria-label="3D view: drag to turn, wheel to zoom, right button to move" {}
                        dl id="readout" {}
                        (legend())
                    }
                    aside aria-label="Pads and plots" {
                        section id="pads" aria-label="Tactile pads" {}
                        section id="plots" aria-label="Plots over time" {}
                    }
                }
                (player())
                dialog id="keys" aria-label="Keys" {
                    h2 { "Keys" }
                    table { @for (key, does) in KEYS { tr { th { kbd { (key) } } td { (does) } } } }
                    form method="dialog" { button { "Close" } }
                }
                script type="application/json" id="faults" { "[]" }
                script type="application/json" id="run" { (PreEscaped(json)) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    Ok(markup.into_string())
}
