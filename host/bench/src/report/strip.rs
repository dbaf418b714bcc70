//! Images of a scene side by side with their error maps below, and a wipe between one image and its reference.

use maud::{Markup, html};

use super::images::{ReportImage, ReportImages};
use super::load::Measured;
use super::name::Names;
use super::number::number;
use super::scene::ReportScene;
use crate::error::FLIP;

/// Images of a run configuration.
struct Shown {
    name: String,
    numbers: String,
    image: ReportImage,
    error_map: Option<ReportImage>,
    reference: Option<ReportImage>,
}

/// Strip and wipe of a scene with at most `count` configurations; none where no configuration has an image.
pub fn strip(
    scene: &ReportScene,
    names: &Names,
    images: &mut ReportImages,
    count: usize,
) -> anyhow::Result<Option<Markup>> {
    let has_image = |run: &Measured| run.result.error.as_ref().is_some_and(|error| error.image.is_some());
    let mut shown = Vec::new();
    for run in scene.chosen(names, count, has_image) {
        shown.extend(load(run, names, images)?);
    }
    if shown.is_empty() {
        return Ok(None);
    }
    let mut references: Vec<ReportImage> = Vec::new();
    for reference in shown.iter().filter_map(|run| run.reference) {
        if !references.contains(&reference) {
            references.push(reference);
        }
    }
    Ok(Some(html! {
        div .strip tabindex="0" role="group" aria-label={ "Images of " (scene.title) } {
            @for reference in &references {
                figure .tile {
                    (reference.show(&format!("Reference of {}", scene.title)))
                    figcaption { b { "Reference" } }
                }
            }
            @for run in &shown {
                figure .tile {
                    (run.image.show(&format!("{} by {}", scene.title, run.name)))
                    @if let Some(map) = &run.error_map { (map.show(&format!("FLIP of {}", run.name))) }
                    figcaption { b { (run.name) } span .dim { (run.numbers) } }
                }
            }
        }
        @if shown.iter().any(|run| run.error_map.is_some()) {
            p .note { "Below each image its FLIP: black is equal, light yellow is as different as can be." }
        }
        (wipe(scene, &shown))
    }))
}

fn load(run: &Measured, names: &Names, images: &mut ReportImages) -> anyhow::Result<Option<Shown>> {
    let Some(error) = &run.result.error else { return Ok(None) };
    let mut get = |name: &Option<String>| match run.beside(name) {
        Some(path) => images.get(&path),
        None => Ok(None),
    };
    let Some(image) = get(&error.image)? else { return Ok(None) };
    let flip = error.get(&FLIP).map(|value| format!("FLIP {}", number(value)));
    let ms = run.result.time.as_ref().map(|time| format!("{} ms", number(time.total_ms.median)));
    Ok(Some(Shown {
        name: names.label(run),
        numbers: flip.into_iter().chain(ms).collect::<Vec<_>>().join(" · "),
        image,
        error_map: get(&error.error_map)?,
        reference: get(&error.reference)?,
    }))
}

/// Wipe: the image is left of the handle, its reference right of it.
fn wipe(scene: &ReportScene, shown: &[Shown]) -> Markup {
    let able: Vec<(&Shown, ReportImage)> =
        shown.iter().filter_map(|run| Some((run, run.reference?))).collect();
    // Start with the first method that has light paths, since path tracing is noisy.
    let Some((first, reference)) =
        able.iter().find(|(run, _)| !run.name.starts_with("path")).or(able.first())
    else {
        return Markup::default();
    };
    let view = format!("0 0 {} {}", first.image.width, first.image.height);
    html! {
        div .wipe-box {
            label .wipe-choice {
                span { "Compare with the reference" }
                select data-wipe-choice {
                    @for (run, reference) in &able {
                        option value=(run.image.reference()) data-reference=(reference.reference())
                            data-view=(format!("0 0 {} {}", run.image.width, run.image.height))
                            selected[std::ptr::eq(*run, *first)] { (run.name) }
                    }
                }
            }
            div .wipe data-wipe {
                svg .image viewBox=(view) role="img" aria-label={ "Reference of " (scene.title) } {
                    use data-part="reference" href=(reference.reference()) {}
                }
                svg .image.over viewBox=(view) role="img" aria-label={ "The chosen image of " (scene.title) } {
                    use data-part="cell" href=(first.image.reference()) {}
                }
                span .tag.left { (first.name) }
                span .tag.right { "reference" }
                div .handle role="slider" tabindex="0" aria-label="Part of the width that shows the chosen image"
                    aria-valuemin="0" aria-valuemax="100" aria-valuenow="50" aria-valuetext="50 %" { span .knob {} }
            }
        }
    }
}
