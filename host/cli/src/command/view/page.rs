//! The page: one document without external parts.

use caustics::scene::Scene;
use caustics_bench::report;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::json;

use super::request::ViewRequest;

mod panel;

const STYLE: &str = include_str!("page/view.css");
/// Parts of the script, in the order of their dependencies.
const SCRIPT: &str = concat!(
    "'use strict';\n(() => {\n",
    include_str!("page/camera.js"),
    include_str!("page/screen.js"),
    include_str!("page/controls.js"),
    include_str!("page/objects.js"),
    include_str!("page/inspector.js"),
    include_str!("page/view.js"),
    include_str!("page/status.js"),
    include_str!("page/panel.js"),
    include_str!("page/connection.js"),
    "})();\n",
);

/// The page and its security policy.
pub struct Page {
    html: String,
    policy: String,
}

impl Page {
    /// Makes the page of a scene. `run` identifies this run of the program, and is a secret that marks the page's own
    /// script.
    pub fn new(scene: &Scene, request: &ViewRequest, run: &str) -> Page {
        let policy = format!(
            "default-src 'none'; script-src 'nonce-{run}'; style-src 'nonce-{run}'; img-src blob: data:; connect-src 'self'; \
             base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        );
        Page { html: document(scene, request, run).into_string(), policy }
    }

    /// The document.
    pub fn html(&self) -> &str {
        &self.html
    }

    /// Content security policy: the page runs its own script and loads nothing.
    pub fn policy(&self) -> &str {
        &self.policy
    }
}

fn document(scene: &Scene, request: &ViewRequest, run: &str) -> Markup {
    let [lower, upper] = scene.bounds;
    let distance = if lower == upper { 1.0 } else { 0.5 * lower.distance(upper) };
    let data = json!({ "scene": scene.name, "run": run, "distance": distance, "size": request.size });
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (scene.name) " · caustics" }
                link rel="icon" href="data:,";
                style nonce=(run) { (PreEscaped(report::STYLE)) (PreEscaped(STYLE)) }
            }
            body data-page=(data.to_string()) {
                (view())
                (bar(scene))
                (panel::panel(scene, request))
                script nonce=(run) { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

/// Area of the image: it keeps its aspect, and messages lie over it.
fn view() -> Markup {
    html! {
        main .view {
            div #stage tabindex="0" role="application" aria-label="Rendered image: drag to orbit, shift and drag to pan, scroll to move closer" {
                canvas .image {}
                canvas .image .over hidden {}
                canvas #overlay hidden {}
                div #mark hidden {}
                div .handle role="slider" tabindex="0" aria-label="Wipe" aria-valuemin="0" aria-valuemax="100" aria-valuenow="50" {}
            }
            div .messages {
                p #failure role="alert" hidden {}
                p #notice role="alert" hidden {}
            }
        }
    }
}

/// Scene, progress and the most used actions; it stays when the panel is hidden.
fn bar(scene: &Scene) -> Markup {
    html! {
        header .bar {
            h1 { (scene.name) }
            p #state role="status" { "connecting" }
            p .dim { span #scale {} span #size {} span #pages {} }
            div .buttons {
                button #inspect type="button" aria-pressed="false" data-control { "Inspect pixel" }
                button #pause type="button" aria-pressed="false" data-control { "Pause" }
                button #toggle type="button" aria-controls="panel" aria-expanded="true" aria-keyshortcuts="H" title="Hide or show the panel (H)" {
                    "Hide panel"
                }
                button #take type="button" hidden { "Take control" }
                button #restore type="button" data-control hidden { "Restore my last settings" }
            }
        }
    }
}
