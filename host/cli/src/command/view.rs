//! `caustics view`: serves a page that shows a scene live.
//!
//! One thread renders ([`engine`]), another serves ([`server`]). They share ([`shared`]) the view request, which the page
//! with the control token changes ([`request`]), and the latest image and messages.

mod accept;
mod connection;
mod control_token;
mod distance;
mod edited;
mod engine;
mod guard;
mod line;
mod look;
mod pace;
mod packet;
mod page;
mod pick;
mod recording;
mod render_job;
mod request;
mod save;
mod server;
mod share;
mod shared;
mod site;
mod status;
#[cfg(test)]
mod taken;

use std::net::{SocketAddr, TcpListener};
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use caustics::scene::{self, CameraChoice, Eye, Position, Staged, Viewpoint};
use caustics::threads;
use caustics_bench::parameter::{HISTORY, PATH_HISTORY};
use caustics_bench::run_config::RunConfig;
use caustics_kernels::history::VALIDATED;
use caustics_kernels::interface::choice::PathHistory;
use tokio::runtime;
use tokio::sync::Semaphore;

use self::accept::accept;
use self::control_token::ControlToken;
use self::edited::{Edited, by_node, if_any};
use self::engine::Engine;
use self::guard::Guard;
use self::look::{Layer, Look};
use self::page::Page;
use self::request::{Against, ViewRequest};
use self::server::router;
use self::shared::Shared;
use self::site::Site;
use super::interrupt::end_on_signal;
use super::open::{edits, staged};
use super::options::{check_rays, check_size};
use super::pick::pick;
use crate::cli::{Usage, Viewer};

/// Environment variable with the token, so that a page outlives the program that served it.
const TOKEN: &str = "CAUSTICS_VIEW_TOKEN";

/// Threads that encode images for pages.
const PACKERS: usize = 4;
/// Maximum number of files in transfer to pages; others wait.
const MAX_FILES: usize = 4;

const NO_NUMBERS: &str = "the system gives no random numbers, which a secret needs";

/// Threads besides the renderer: for Ctrl-C, for ending a program that hangs then, for connections, and for encoding
/// images.
const THREADS: usize = 3 + PACKERS;

/// Serves a page until Ctrl-C.
pub fn run(options: &Viewer) -> anyhow::Result<ExitCode> {
    let view = &options.view;
    check_size(view.width, view.height)?;
    if !options.time.is_finite() {
        return Err(Usage(format!("--time {}: give a number of seconds", options.time)).into());
    }
    if !(0.1..=240.0).contains(&options.target_fps) {
        return Err(Usage(format!("--target-fps {}: give 0.1 to 240", options.target_fps)).into());
    }
    let run_config = run_config(options)?;
    check_rays(&run_config.config, view.width, view.height)?;
    // Report a missing device now, since later only a page could report it. `auto` always finds a runner.
    let gather = run_config.config.gather.filter(|_| run_config.config.method.chooses_gather);
    pick(run_config.asked_runner, &options.machine, gather)?.0.check()?;
    threads::check(THREADS).context("a page takes threads of its own")?;
    let guard = match std::env::var(TOKEN) {
        Ok(token) => Guard::chosen(&token).map_err(|wrong| Usage(format!("{TOKEN}: {wrong}")))?,
        Err(_) => Guard::random().context(NO_NUMBERS)?,
    };
    let address = SocketAddr::new(options.bind, options.port);
    let listener = TcpListener::bind(address)
        .with_context(|| format!("--port {}: cannot listen at {address}", options.port))?;
    listener.set_nonblocking(true)?;
    let address = listener.local_addr()?;

    let file = scene::resolve(&options.scene)?;
    let edits = options.edits.as_deref().map(|path| edits(path, view)).transpose()?.unwrap_or_default();
    let staged = staged(&file, view, &options.loading, if_any(&edits))?;
    for note in &staged.notes {
        message!("{note}");
    }
    let request = ViewRequest {
        camera: looked_through(&staged)?,
        at: 0.0,
        time: options.time,
        playing: None,
        size: [view.width, view.height],
        target_fps: options.target_fps,
        run_configs: [run_config.clone(), run_config],
        against: Against::Nothing,
        look: Look { layer: Layer::Beauty, exposure: view.exposure },
        moves_until: None,
        nodes: by_node(&edits),
        records: false,
        paused: false,
    };
    let run = Guard::random().context(NO_NUMBERS)?.token().to_string();
    let page = Page::new(&staged.scene, &request, &run);
    let shared = Shared::new(request);
    let ends = Arc::clone(&shared);
    end_on_signal(move || ends.end())?;
    let site = Arc::new(Site {
        shared: Arc::clone(&shared),
        guard,
        page,
        run,
        control_token: ControlToken::new(),
        files: Arc::new(Semaphore::new(MAX_FILES)),
        packers: Arc::new(Semaphore::new(PACKERS)),
    });
    let runtime = runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .max_blocking_threads(PACKERS)
        .enable_io()
        .enable_time()
        .build()
        .context("cannot start threads")?;
    message!("{}", address_message(address, site.guard.token()));
    let listener = {
        let _inside = runtime.enter();
        tokio::net::TcpListener::from_std(listener)?
    };
    runtime.spawn(accept(listener, router(site)));
    Engine::new(shared, options, Edited::new(staged.scene, file, &edits)).run();
    // This closes pages that are still connected.
    runtime.shutdown_background();
    Ok(ExitCode::SUCCESS)
}

/// Default configuration: with histories while something moves.
fn run_config(options: &Viewer) -> Result<RunConfig, Usage> {
    let histories = [(&HISTORY, VALIDATED.name), (&PATH_HISTORY, PathHistory::Validated.name())];
    let defaults: Vec<_> =
        histories.into_iter().filter(|_| !options.parameters.has_render_options()).collect();
    options.parameters.checked(options.parameters.unchecked(&defaults)?)
}

/// Returns the camera; a placed one by its position.
fn looked_through(staged: &Staged) -> anyhow::Result<CameraChoice> {
    let name = &staged.camera;
    // The name of a placed camera consists of the options that place it.
    let words: Vec<&str> = name.split(' ').collect();
    let ["--from", from, "--look-at", look_at, "--fov", fov] = words[..] else {
        return Ok(CameraChoice::Named(name.clone()));
    };
    let position = |text: &str| text.parse::<Position>().map_err(Usage);
    let [from, look_at] = [position(from)?, position(look_at)?];
    Ok(CameraChoice::Placed(Viewpoint {
        eye: Some(Eye::At(from)),
        look_at: Some(look_at),
        field: Some(fov.parse()?),
    }))
}

/// Returns the message with the address of the page.
fn address_message(address: SocketAddr, token: &str) -> String {
    let page = format!("http://{address}/?token={token}");
    if address.ip().is_loopback() {
        return format!(
            "{page}\nthis machine alone reaches it; from another one: ssh -L {0}:{address} ...; Ctrl-C ends",
            address.port()
        );
    }
    format!(
        "{page}\nwarning: --bind {}: everybody in your network reaches it, and what is sent can be read on the way; who has the token \
         can read this scene and use this machine's time",
        address.ip()
    )
}
