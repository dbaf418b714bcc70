//! Renders a scene to an EXR file with caustics as a library:
//!
//! ```sh
//! cargo run --release --example render -- mirror-room out.exr
//! ```

use std::path::Path;

use anyhow::Context;
use caustics::accumulation::Accumulation;
use caustics::output::{exr, target::Target};
use caustics::{Paths, RenderConfig, Scene, Session, scene};

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let (Some(name), Some(output)) = (arguments.next(), arguments.next()) else {
        anyhow::bail!("give a scene and the EXR file to write");
    };
    let scene = Scene::load(&scene::resolve(&name)?)?;
    let config = RenderConfig {
        width: 480,
        height: 270,
        light_paths: Paths::Count(1 << 17),
        ..RenderConfig::default()
    };
    let mut session = Session::builder(&scene).config(config).build()?;

    // Average independent frames and estimate the variance of their mean.
    let mut sums = Accumulation::default();
    for frame in 0..4 {
        session.frame(frame)?;
        sums.add(&session.image()?);
    }
    let variance = sums.variance().context("two frames or more have a variance")?;
    let bytes = exr::encode(&sums.mean(), Some((variance, sums.frames())), &Default::default())?;
    Target::claim(Path::new(&output), false)?.finish(&bytes)?;
    println!("{output}: {} frames of {} on {}", sums.frames(), scene.name, session.device());
    Ok(())
}
