//! Panel of the page: folded sections of settings and information.

use caustics::scene::{CameraChoice, Scene};
use caustics_bench::parameter::{
    CAUSTICS, FEATURES, FIREFLIES, LIGHT_SAMPLER, PARAMETERS, Parameter, SAMPLER, Values,
};
use maud::{Markup, html};

use crate::command::view::edited::label;
use crate::command::view::look::Layer;
use crate::command::view::request::ViewRequest;

/// Choices of the image to compare with: value and description.
const AGAINST: [(&str, &str); 3] =
    [("nothing", "nothing"), ("other", "another setting"), ("reference", "path-traced reference")];
/// Parameters that are folded within a setting.
static RARELY_USED: [&Parameter; 5] = [&CAUSTICS, &LIGHT_SAMPLER, &SAMPLER, &FIREFLIES, &FEATURES];
/// Mouse, touch and keys, and their effects.
const INPUTS: [(&str, &str); 9] = [
    ("drag", "orbit"),
    ("shift and drag, right button", "pan"),
    ("alt and drag", "look around"),
    ("wheel, two fingers", "closer, further"),
    ("W A S D Q E", "fly; with shift, faster"),
    ("arrow keys", "orbit"),
    ("click", "show the material, choose the object"),
    ("double click", "orbit around the point"),
    ("H", "hide or show the panel"),
];

/// Returns the panel.
pub fn panel(scene: &Scene, request: &ViewRequest) -> Markup {
    let two_settings = html! { "Setting" span .side { ", left of the wipe" } };
    html! {
        aside #panel aria-label="Panel" {
            details #warned .section hidden { summary { h2 #warning-count { "Warnings" } } ul #warnings {} }
            (section("camera-and-display", &html! { "View" }, true, &view(scene, request)))
            (section("comparison", &html! { "Compare" }, true, &html! {
                (field("against", "Compare with", &select("against", &AGAINST)))
                table #distance hidden {}
            }))
            (section("own", &two_settings, true, &parameters(0)))
            details #other .section open hidden {
                summary { h2 { "Setting, right of the wipe" } }
                (parameters(1))
            }
            (objects(scene))
            (section("pixel", &html! { "Pixel" }, false, &html! {
                p #picked { "Click the image." }
                table #inspected {}
                p .note {
                    "Inspect pixel draws its camera path (blue), its collection point (green) and light paths of its photons (yellow)."
                }
            }))
            (section("size-and-rate", &html! { "Image size and frame rate" }, false, &size_and_rate()))
            (section("save", &html! { "Save and record" }, false, &save()))
            (section("statistics", &html! { "Statistics" }, false, &statistics()))
            (section("inputs", &html! { "Mouse and keys" }, false, &html! {
                table { @for (input, effect) in INPUTS { tr { th scope="row" { (input) } td { (effect) } } } }
            }))
        }
    }
}

/// Returns a section that folds.
fn section(id: &str, title: &Markup, is_open: bool, content: &Markup) -> Markup {
    html! {
        details id=(id) .section open[is_open] {
            summary { h2 { (title) } }
            (content)
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

/// Camera, time and display of the image.
fn view(scene: &Scene, request: &ViewRequest) -> Markup {
    html! {
        (field("camera", "Camera", &cameras(scene, request)))
        (field("fov", "Field of view (degrees)", &html! { input #fov type="number" min="0.1" max="170" step="any" data-control; }))
        (field("layer", "Layer", &select("layer", &Layer::ALL.map(|(_, name, description)| (name, description)))))
        div .field {
            label for="stops" { "Exposure (stops)" }
            span .pair {
                input #stops type="number" step="0.1" min="-64" max="64" value="0" data-control;
                label .check { input #auto type="checkbox" checked data-control; "auto" }
            }
        }
        @if scene.is_animated() { (time(scene, request)) }
    }
}

fn cameras(scene: &Scene, request: &ViewRequest) -> Markup {
    // A placed camera has its options as name.
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

/// Parameters of a side, the same as the options of the command line.
fn parameters(side: usize) -> Markup {
    let (rare, frequent): (Vec<_>, Vec<_>) =
        PARAMETERS.into_iter().partition(|parameter| RARELY_USED.contains(parameter));
    html! {
        @for parameter in frequent { (parameter_field(parameter, side)) }
        details .more {
            summary { "More parameters" }
            @for parameter in rare { (parameter_field(parameter, side)) }
        }
        p .note id=(format!("not-applicable-{side}")) hidden {}
    }
}

fn parameter_field(parameter: &Parameter, side: usize) -> Markup {
    let id = format!("parameter-{side}-{}", parameter.key);
    let key = parameter.key;
    html! {
        div .field {
            label for=(id) title=(parameter.description) { (parameter.head) }
            @match parameter.values {
                Values::Names(names) => {
                    select id=(id) data-parameter=(key) data-side=(side) data-control {
                        // An empty value leaves the choice to the machine.
                        @if parameter.default.is_empty() { option value="" { "auto" } }
                        @for (name, description) in names() {
                            option value=(name) title=(description) { (name) }
                        }
                    }
                }
                Values::Numbers(allowed) => {
                    input id=(id) data-parameter=(key) data-side=(side) data-control title=(allowed) spellcheck="false";
                }
            }
        }
    }
}

/// List of movable nodes: those of the file with a mesh or a light.
fn objects(scene: &Scene) -> Markup {
    let tree = scene.node_tree();
    let movable: Vec<_> = tree.iter().filter(|node| node.has_mesh || node.has_light).collect();
    let content = html! {
        div .field {
            label for="node" { "Object" }
            select #node data-control {
                option value="" { "none" }
                @for node in &movable { option value=(node.index) { (label(node)) } }
            }
        }
        div #placing hidden {
            p .buttons {
                button #move type="button" aria-pressed="false" data-control { "Move by dragging" }
                button #put-back type="button" data-control { "Reset" }
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
    };
    html! { @if !movable.is_empty() { (section("objects", &html! { "Objects" }, false, &content)) } }
}

fn size_and_rate() -> Markup {
    html! {
        div .field {
            label for="width" { "Width, height (px)" }
            span .pair {
                input #width type="number" min="1" max="16384" aria-label="Width (px)" data-control;
                input #height type="number" min="1" max="16384" aria-label="Height (px)" data-control;
            }
        }
        (field("rate", "Frames/s while moving", &html! { input #rate type="number" min="0.1" max="240" step="any" data-control; }))
    }
}

fn save() -> Markup {
    html! {
        p .buttons {
            button type="button" data-save="image.png" { "Save PNG" }
            button type="button" data-save="image.exr" { "Save EXR" }
            button #save-edits type="button" data-save="edits.toml" hidden { "Save edits" }
            button #record type="button" aria-pressed="false" data-control { "Record" }
            button #save-recording type="button" data-save="animation.toml" hidden { "Save animation" }
            button #copy type="button" disabled { "Copy command" }
        }
        pre { code #command {} }
    }
}

fn statistics() -> Markup {
    html! {
        p #device .dim {}
        table #numbers {}
        details #numbers-other hidden { summary { "Right of the wipe" } table {} }
        details { summary { "Time of the passes" } table #passes {} }
    }
}
