//! Shows an image while it converges: in the PNG, and in the viewer tev (https://github.com/Tom94/tev).

use std::net::{TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use caustics::exposure::Exposure;
use caustics::output::png;
use caustics::output::target::Target;
use caustics::rendered_image::RenderedImage;
use caustics_kernels::pass::display::tone_mapped;
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use super::checkpoint_writer::CheckpointWriter;
use super::options::duration;
use crate::cli::{Common, Usage};

/// Default time between images sent to tev.
const DEFAULT_INTERVAL: Duration = Duration::from_secs(2);
/// Maximum wait for tev.
const PATIENCE: Duration = Duration::from_secs(10);
/// Channels sent to tev.
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// Destinations of an image that converges. A failure there is reported once, and the run continues.
pub struct Live {
    every: Duration,
    last: Option<Instant>,
    png: Option<(PathBuf, CheckpointWriter)>,
    viewer: Option<Viewer>,
    exposure: Exposure,
}

impl Live {
    /// Opens the destinations that the options name, and connects to tev.
    pub fn new(options: &Common) -> anyhow::Result<Live> {
        let refresh = options.refresh.map(|seconds| duration("--refresh", seconds)).transpose()?;
        if refresh.is_some() && options.png.is_none() && options.tev.is_none() {
            return Err(Usage("--refresh: there is nothing to show; give --png or --tev".into()).into());
        }
        let png = options.png.clone().filter(|_| refresh.is_some());
        Ok(Live {
            every: refresh.unwrap_or(DEFAULT_INTERVAL),
            last: None,
            png: png.map(|path| (path, CheckpointWriter::new("the PNG of the image so far"))),
            viewer: options.tev.as_deref().map(|at| Viewer::open(at, &options.output)).transpose()?,
            exposure: options.view.exposure,
        })
    }

    /// Whether the PNG is written before the run is done.
    pub fn has_png(&self) -> bool {
        self.png.is_some()
    }

    /// Shows the image so far, if the interval has passed.
    pub fn show(&mut self, image: impl FnOnce() -> RenderedImage) {
        let is_new = self.last.is_none_or(|last| last.elapsed() >= self.every);
        if !is_new || (self.png.is_none() && self.viewer.is_none()) {
            return;
        }
        let image = image();
        if let Some((path, checkpoint_writer)) = &mut self.png {
            checkpoint_writer.keep(write(path, &image, self.exposure));
        }
        self.send(&image);
        self.last = Some(Instant::now());
    }

    /// Sends an image to tev, if it is connected.
    pub fn send(&mut self, image: &RenderedImage) {
        if let Some(viewer) = &mut self.viewer
            && let Err(error) = viewer.send(image)
        {
            message!("warning: tev is sent no more, and the run goes on without: {error}");
            self.viewer = None;
        }
    }
}

/// Overwrites the PNG with the image so far. Its colours are the device's, up to about one step.
fn write(path: &Path, image: &RenderedImage, exposure: Exposure) -> anyhow::Result<()> {
    let scale = exposure.stops_for(image).exp2() as f32;
    let colors: Vec<_> = image.beauty().into_iter().map(|color| tone_mapped(color, scale)).collect();
    let bytes = png::encode(image.width as u32, image.height as u32, &colors)?;
    Ok(Target::claim(path, true)?.finish(&bytes)?)
}

/// The viewer tev and the name of the image that it shows.
struct Viewer {
    client: TevClient,
    name: String,
    is_open: bool,
}

impl Viewer {
    /// Connects to tev; the image has the name of its file.
    fn open(at: &str, output: &Path) -> anyhow::Result<Viewer> {
        let hint =
            || format!("--tev {at}: no viewer answers; start tev, or give where it listens as HOST:PORT");
        let addresses = at.to_socket_addrs().with_context(hint)?;
        let mut result = Err(anyhow!("the name has no address"));
        for address in addresses {
            result = TcpStream::connect_timeout(&address, PATIENCE).map_err(Into::into);
            if result.is_ok() {
                break;
            }
        }
        let stream = result.with_context(hint)?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let name = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Viewer { client: TevClient::wrap(stream), name, is_open: false })
    }

    fn send(&mut self, image: &RenderedImage) -> std::io::Result<()> {
        let (width, height) = (image.width as u32, image.height as u32);
        let (image_name, channel_names) = (&*self.name, &CHANNELS[..]);
        if !self.is_open {
            let grab_focus = true;
            self.client.send(PacketCreateImage { image_name, grab_focus, width, height, channel_names })?;
            self.is_open = true;
        }
        self.client.send(PacketUpdateImage {
            image_name,
            grab_focus: false,
            channel_names,
            channel_offsets: &[0, 1, 2],
            channel_strides: &[3, 3, 3],
            x: 0,
            y: 0,
            width,
            height,
            data: bytemuck::cast_slice(&image.beauty()),
        })
    }
}
