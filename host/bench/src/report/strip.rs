//! Images of a scene side by side with their errors below, and one of them wiped over its reference.

use maud::{Markup, html};

use super::images::{ReportImage, ReportImages};
use super::load::Measured;
use super::name::Names;
use super::number::number;
use super::scene::ReportScene;
use crate::error::FLIP;

/// A cell's images.
struct Shown {
    name: String,
    numbers: String,
    image: ReportImage,
    error_map: Option<ReportImage>,
    reference: Option<ReportImage>,
}

/// Strip and wipe of a scene with at most `count` cells; none where no cell has an image.
pub fn strip(
    scene: &ReportScene,
    names: &Names,
    images: &mut ReportImages,
    count: usize,
) -> anyhow::Result<Option<Markup>> {
    let has_image = |cell: &Measured| cell.result.error.as_ref().is_some_and(|error| error.image.is_some());
    let mut shown = Vec::new();
    for cell in scene.chosen(names, count, has_image) {
        shown.extend(load(cell, names, images)?);
    }
    if shown.is_empty() {
        return Ok(None);
    }
    let mut references: Vec<ReportImage> = Vec::new();
    for reference in shown.iter().filter_map(|cell| cell.reference) {
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
            @for cell in &shown {
                figure .tile {
                    (cell.image.show(&format!("{} by {}", scene.title, cell.name)))
                    @if let Some(map) = &cell.error_map { (map.show(&format!("FLIP of {}", cell.name))) }
                    figcaption { b { (cell.name) } span .dim { (cell.numbers) } }
                }
            }
        }
        @if shown.iter().any(|cell| cell.error_map.is_some()) {
            p .note { "Below each image its FLIP: black is equal, light yellow is as different as can be." }
        }
        (wipe(scene, &shown))
    }))
}

fn load(cell: &Measured, names: &Names, images: &mut ReportImages) -> anyhow::Result<Option<Shown>> {
    let Some(error) = &cell.result.error else { return Ok(None) };
    let mut get = |name: &Option<String>| match cell.beside(name) {
        Some(path) => images.get(&path),
        None => Ok(None),
    };
    let Some(image) = get(&error.image)? else { return Ok(None) };
    let flip = error.get(&FLIP).map(|value| format!("FLIP {}", number(value)));
    let ms = cell.result.time.as_ref().map(|time| format!("{} ms", number(time.total_ms.median)));
    Ok(Some(Shown {
        name: names.label(cell),
        numbers: flip.into_iter().chain(ms).collect::<Vec<_>>().join(" · "),
        image,
        error_map: get(&error.error_map)?,
        reference: get(&error.reference)?,
    }))
}

/// The wipe: the cell is left of the handle, its reference right of it.
fn wipe(scene: &ReportScene, shown: &[Shown]) -> Markup {
    let able: Vec<(&Shown, ReportImage)> =
        shown.iter().filter_map(|cell| Some((cell, cell.reference?))).collect();
    // The image that is furthest from path tracing's noise is not known: the first with light paths is a fair start.
    let Some((first, reference)) =
        able.iter().find(|(cell, _)| !cell.name.starts_with("path")).or(able.first())
    else {
        return Markup::default();
    };
    let view = format!("0 0 {} {}", first.image.width, first.image.height);
    html! {
        div .wipe-box {
            label .wipe-choice {
                span { "Compare with the reference" }
                select data-wipe-choice {
                    @for (cell, reference) in &able {
                        option value=(cell.image.reference()) data-reference=(reference.reference())
                            data-view=(format!("0 0 {} {}", cell.image.width, cell.image.height))
                            selected[std::ptr::eq(*cell, *first)] { (cell.name) }
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
