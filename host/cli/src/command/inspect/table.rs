//! An inspection as text for the user.

use std::fmt::Write;

use caustics::inspect::{CameraPath, Inspection, LightPath, Photons, Point, SharedLight, Vertex};
use caustics::text::cut;

/// Maximum length of a name (characters).
const NAME: usize = 24;

/// Table of the whole inspection, one line per vertex.
pub fn table(inspection: &Inspection) -> String {
    let Inspection { pixel: [x, y], frame, camera_path, point, photons, light_paths, shared_light } =
        inspection;
    let CameraPath { eye, vertices, leaves, .. } = camera_path;
    let mut text = format!("pixel {x},{y} of frame {frame}\n\ncamera path from {}\n", position(eye));
    rows(&mut text, vertices, "throughput");
    if let Some(direction) = leaves {
        line(&mut text, format_args!("  leaves the scene towards {}", triple(direction)));
    }
    match point {
        None => line(&mut text, format_args!("\nno collection point")),
        Some(Point { radius, depth, throughput, .. }) => line(
            &mut text,
            format_args!(
                "\ncollection point: vertex {depth}, a disc of radius {radius:.3e} m, seen through {}",
                triple(throughput)
            ),
        ),
    }
    if let Some(SharedLight { radius, own, mean, change, points }) = shared_light {
        line(
            &mut text,
            format_args!(
                "shared indirect light: {} points within {radius:.3e} m have {} W/(m^2 sr) on average, this one {}; the pixel changes by {}",
                points.len(),
                triple(mean),
                triple(own),
                triple(change)
            ),
        );
    }
    if let Some(photons) = photons {
        add_photons(&mut text, photons);
        for (path, photon) in light_paths.iter().zip(&photons.some) {
            let LightPath { path, light, start, flux, vertices, .. } = path;
            let light =
                light.map_or("a light".into(), |light| format!("light {} ({})", light.id, light.kind));
            line(
                &mut text,
                format_args!("\nlight path {path} from {light} at {}, {} W", position(start), triple(flux)),
            );
            rows(&mut text, vertices, "flux (W)");
            line(&mut text, format_args!("  gives the pixel {} W/(m^2 sr)", triple(&photon.radiance)));
        }
    }
    text.truncate(text.trim_end().len());
    text
}

/// Adds the summary of all photons.
fn add_photons(text: &mut String, photons: &Photons) {
    let Photons { gathered, count, light_paths, skipped, flux, radiance, .. } = photons;
    line(
        text,
        format_args!(
            "photons: {count} of {light_paths} light paths, {} W, give the pixel {} W/(m^2 sr)",
            triple(flux),
            triple(radiance)
        ),
    );
    if gathered != count {
        line(
            text,
            format_args!("the frame itself gathered {gathered}: a device rounds otherwise than a CPU"),
        );
    }
    if *skipped > 0 {
        line(text, format_args!("{skipped} light paths are left out: what they started by is gone"));
    }
}

/// Adds one line per vertex, in columns.
fn rows(text: &mut String, vertices: &[Vertex], carries: &str) {
    let cells: Vec<[String; 5]> = vertices
        .iter()
        .enumerate()
        .map(|(index, vertex)| {
            let name = vertex.event.name().replace('-', " ");
            [
                format!("{}", index + 1),
                if vertex.lobes.is_empty() { name } else { format!("{name}: {}", vertex.lobes.join("/")) },
                cut(&vertex.material, NAME).replace('\n', "\\n"),
                position(&vertex.position),
                format!("{carries} {}", triple(&vertex.carries)),
            ]
        })
        .collect();
    let width = |column: usize| cells.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    for [number, event, material, position, carries] in &cells {
        let widths = (width(0), width(1), width(2), width(3));
        line(
            text,
            format_args!(
                "  {number:>0$}  {event:1$}  {material:2$}  {position:3$}  {carries}",
                widths.0, widths.1, widths.2, widths.3
            ),
        );
    }
}

fn line(text: &mut String, line: std::fmt::Arguments<'_>) {
    writeln!(text, "{line}").expect("a String takes all");
}

fn position(position: &[f64; 3]) -> String {
    let [x, y, z] = position;
    format!("({x:.4}, {y:.4}, {z:.4})")
}

fn triple(values: &[f32; 3]) -> String {
    let number = |value: &f32| if *value == 0.0 { "0".into() } else { format!("{value:.3e}") };
    let of_size = |value: &f32| {
        if (1.0e-3..1.0e4).contains(&value.abs()) { format!("{value:.4}") } else { number(value) }
    };
    values.iter().map(of_size).collect::<Vec<_>>().join(" ")
}
