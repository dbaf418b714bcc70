//! The page: one document that holds all it needs.

use caustics::scene::{CameraChoice, Scene};
use caustics_bench::parameter::{PARAMETERS, Parameter, Values};
use caustics_bench::report;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::json;

use super::edited::label;
use super::look::Layer;
use super::request::ViewRequest;

const STYLE: &str = include_str!("page/view.css");
/// Parts of the script, in the order in which they need each other.
const SCRIPT: &str = concat!(
    "'use strict';\n(() => {\n",
    include_str!("page/camera.js"),
    include_str!("page/screen.js"),
    include_str!("page/controls.js"),
    include_str!("page/objects.js"),
    include_str!("page/inspector.js"),
    include_str!("page/view.js"),
    "})();\n",
);
/// What an image can be held against: value, and what it is.
const AGAINST: [(&str, &str); 3] =
    [("nothing", "nothing"), ("other", "other settings"), ("reference", "the reference, path traced")];

/// The page, and what it may do.
pub struct Page {
    html: String,
    policy: String,
}

impl Page {
    /// The page of a scene; `run` tells this run of the program from others, and is a secret that marks the page's own script.
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

    /// Its Content-Security-Policy: it runs its own script and loads nothing.
    pub fn policy(&self) -> &str {
        &self.policy
    }
}

fn document(scene: &Scene, request: &ViewRequest, run: &str) -> Markup {
    let [lower, upper] = scene.bounds;
    let distance = if lower == upper { 1.0 } else { 0.5 * lower.distance(upper) };
    let data = json!({ "scene": scene.name, "run": run, "distance": distance });
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
                header {
                    h1 { (scene.name) }
                    p #state role="status" { "connecting" }
                    p #scale .dim {}
                    p #pages .dim {}
                    button #take type="button" hidden { "Take control" }
                    button #restore type="button" data-control hidden { "Restore my last settings" }
                }
                main {
                    (stage())
                    (panel(scene, request))
                }
                script nonce=(run) { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

/// Where images are.
fn stage() -> Markup {
    html! {
        div .theatre {
            div #stage tabindex="0" role="application" aria-label="Image: drag to orbit, shift and drag to pan, wheel to come closer" {
                canvas .image {}
                canvas .image .over hidden {}
                canvas #overlay hidden {}
                div #mark hidden {}
                div .handle role="slider" tabindex="0" aria-label="Wipe" aria-valuemin="0" aria-valuemax="100" aria-valuenow="50" {}
            }
            p #notice role="alert" hidden {}
            p #failure role="alert" hidden {}
            div .tools {
                button #inspect type="button" aria-pressed="false" data-control { "Inspect a pixel" }
                p #picked .dim {}
            }
            table #inspected {}
            p .note {
                "Drag to orbit, with shift to pan, with alt to look around; the wheel or two fingers come closer. W A S D Q E fly, arrows "
                "turn. A double click is what the camera turns round."
            }
        }
    }
}

/// What can be set, and what there is to know.
fn panel(scene: &Scene, request: &ViewRequest) -> Markup {
    html! {
        div .controls {
            section aria-label="View" {
                h2 { "View" }
                (field("camera", "Camera", &cameras(scene, request)))
                (field("fov", "Field of view (degrees)", &html! { input #fov type="number" min="0.1" max="170" step="any" data-control; }))
                (field("layer", "Layer", &select("layer", &Layer::ALL.map(|(_, name, description)| (name, description)))))
                div .field {
                    label for="stops" { "Exposure (stops)" }
                    span .pair {
                        input #stops type="number" step="0.1" min="-64" max="64" value="0" data-control;
                        label { input #auto type="checkbox" checked data-control; " auto" }
                    }
                }
                @if scene.is_animated() { (time(scene, request)) }
                (field("against", "Wipe against", &select("against", &AGAINST)))
                table #distance hidden {}
            }
            section aria-label="Method" {
                h2 { "How to render" }
                div .axes {
                    div #own { (parameters(0)) }
                    div #other hidden { h3 { "On the right of the wipe" } (parameters(1)) }
                }
            }
            (objects(scene))
            section aria-label="Size" {
                h2 { "Size and rate" }
                div .field {
                    label for="width" { "Size (px)" }
                    span .pair {
                        input #width type="number" min="1" max="16384" data-control;
                        input #height type="number" min="1" max="16384" aria-label="Height (px)" data-control;
                    }
                }
                (field("rate", "Frames a second while moving", &html! { input #rate type="number" min="0.1" max="240" step="any" data-control; }))
                button #pause type="button" aria-pressed="false" data-control { "Pause" }
            }
            section aria-label="Take it away" {
                h2 { "Take it away" }
                p .buttons {
                    button type="button" data-save="image.png" { "PNG" }
                    button type="button" data-save="image.exr" { "EXR" }
                    button #save-edits type="button" data-save="edits.toml" hidden { "Edits" }
                    button #save-recording type="button" data-save="animation.toml" hidden { "Animation" }
                    button #record type="button" aria-pressed="false" data-control { "Record" }
                    button #copy type="button" disabled { "Copy as command" }
                }
                pre { code #command {} }
            }
            section aria-label="Numbers" {
                h2 { "Numbers" }
                p #device .dim {}
                table #numbers {}
                details #numbers-other hidden { summary { "On the right of the wipe" } table {} }
                details { summary { "Passes" } table #passes {} }
                details #warned hidden { summary { "Warnings" } ul #warnings {} }
            }
        }
    }
}

fn field(id: &str, name: &str, control: &Markup) -> Markup {
    html! { div .field { label for=(id) { (name) } (control) } }
}

fn select(id: &str, options: &[(&str, &str)]) -> Markup {
    html! {
        select id=(id) data-control {
            @for (value, description) in options { option value=(value) title=(description) { (description) } }
        }
    }
}

fn cameras(scene: &Scene, request: &ViewRequest) -> Markup {
    // One that was placed has options for its name.
    let of_file = scene.cameras.iter().filter(|camera| !camera.name.starts_with("--"));
    let is_chosen = |name: &str| matches!(&request.camera, CameraChoice::Named(chosen) if chosen == name);
    html! {
        select #camera data-control {
            option value="" { "free" }
            @for camera in of_file {
                option value=(camera.name) selected[is_chosen(&camera.name)] { (camera.name) }
            }
        }
    }
}

fn time(scene: &Scene, request: &ViewRequest) -> Markup {
    html! {
        div .field {
            label for="time" { "Time" }
            span .pair {
                button #play type="button" aria-pressed="false" data-control { "Play" }
                span #seconds .dim {}
            }
        }
        input #time type="range" min="0" max=(scene.duration()) step="any" value=(request.time) aria-label="Time (s)" data-control;
    }
}

/// What can be moved: nodes of the file with a mesh or a light.
fn objects(scene: &Scene) -> Markup {
    let tree = scene.node_tree();
    let things: Vec<_> = tree.iter().filter(|node| node.has_mesh || node.has_light).collect();
    html! {
        @if !things.is_empty() {
            section aria-label="Objects" {
                h2 { "Objects" }
                div .field {
                    label for="node" { "Object" }
                    select #node data-control {
                        option value="" { "none" }
                        @for node in things { option value=(node.index) { (label(node)) } }
                    }
                }
                div #placing hidden {
                    p .buttons {
                        button #move type="button" aria-pressed="false" data-control { "Move by dragging" }
                        button #put-back type="button" data-control { "Put back" }
                    }
                    div .field {
                        label for="node-x" { "Translation (m)" }
                        span .pair {
                            @for axis in ["x", "y", "z"] {
                                input id={ "node-" (axis) } type="number" step="any" aria-label={ "Translation " (axis) " (m)" } data-control;
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The parameters of a side: the same that are options of the command line.
fn parameters(side: usize) -> Markup {
    html! {
        @for parameter in PARAMETERS {
            @let id = format!("axis-{side}-{}", parameter.key);
            div .field {
                label for=(id) title=(parameter.description) { (parameter.head) }
                (parameter_control(parameter, &id, side))
            }
        }
    }
}

fn parameter_control(parameter: &Parameter, id: &str, side: usize) -> Markup {
    match parameter.values {
        Values::Names(names) => html! {
            select id=(id) data-axis=(parameter.key) data-side=(side) data-control {
                // What the machine decides.
                @if parameter.default.is_empty() { option value="" { "auto" } }
                @for (name, description) in names() {
                    option value=(name) title=(description) { (name) }
                }
            }
        },
        Values::Numbers(which) => html! {
            input id=(id) data-axis=(parameter.key) data-side=(side) data-control title=(which) spellcheck="false";
        },
    }
}
