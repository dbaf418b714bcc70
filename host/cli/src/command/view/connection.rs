//! Connection of a page. An image waits until the page has shown the one before, so a slow page gets fewer images, always
//! the latest.

use std::sync::Arc;
use std::time::Instant;

use axum::extract::ws::{Message as Packet, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{mpsc, watch};
use tokio::task::spawn_blocking;

use super::control_token::RegisteredPage;
use super::line::Line;
use super::look::Look;
use super::packet::packet;
use super::request::Message;
use super::shared::{Content, Query, Shared};
use super::site::Site;

/// Maximum number of messages that wait to be sent; more are dropped.
const MAX_WORDS: usize = 32;

/// Serves a page until it closes.
pub async fn run(socket: WebSocket, site: Arc<Site>, page: RegisteredPage) {
    site.shared.look_on(true);
    let (sink, stream) = socket.split();
    let (words, to_send) = mpsc::channel(MAX_WORDS);
    // The queue has room for the first message.
    let _ = words.try_send(json!({ "is": "hello", "run": site.run }).to_string());
    let (shown, was_shown) = watch::channel(0);
    // The end of one ends the other.
    tokio::select! {
        () = listen(stream, &site.shared, &page, words, shown) => {}
        _ = speak(sink, &site, &page, to_send, was_shown) => {}
    }
    site.shared.look_on(false);
}

/// Carries out the messages of the page.
async fn listen(
    mut stream: SplitStream<WebSocket>,
    shared: &Arc<Shared>,
    page: &RegisteredPage,
    words: mpsc::Sender<String>,
    shown: watch::Sender<u64>,
) {
    while let Some(Ok(packet)) = stream.next().await {
        let text = match packet {
            Packet::Text(text) => text,
            Packet::Close(_) => return,
            Packet::Ping(_) | Packet::Pong(_) => continue,
            Packet::Binary(_) => return,
        };
        let reply = match Message::parse(text.as_bytes()) {
            Err(error) => Some(json!({ "is": "error", "what": error })),
            Ok(Message::Shown { serial }) => {
                shown.send_replace(serial);
                None
            }
            Ok(Message::TakeControl) => {
                page.take_control();
                None
            }
            Ok(_) if !page.has_control() => Some(
                json!({ "is": "error", "what": "another page has control; take control to change this" }),
            ),
            Ok(Message::Pick { x, y }) => {
                answer(shared, "picked", Query::Pick([x, y]), words.clone());
                None
            }
            Ok(Message::Inspect { x, y }) => {
                answer(shared, "inspected", Query::Inspect([x, y]), words.clone());
                None
            }
            Ok(Message::Node { node }) => {
                answer(shared, "node", Query::Node(node), words.clone());
                None
            }
            Ok(message) => shared.take(&message).err().map(|what| json!({ "is": "error", "what": what })),
        };
        if let Some(reply) = reply
            && let Err(TrySendError::Closed(_)) = words.try_send(reply.to_string())
        {
            return;
        }
    }
}

/// Asks the renderer, and sends its answer when it arrives.
fn answer(shared: &Arc<Shared>, is: &'static str, query: Query, words: mpsc::Sender<String>) {
    let query = shared.ask(query);
    tokio::spawn(async move {
        let answer = match query {
            // Stop waiting when the page is gone.
            Ok(answer) => tokio::select! {
                answer = answer => answer.unwrap_or_else(|_| Err("the program ends".into())),
                () = words.closed() => return,
            },
            Err(error) => Err(error),
        };
        let found = answer.and_then(|content| match content {
            Content::Bytes(bytes) => {
                serde_json::from_slice::<Value>(&bytes).map_err(|error| error.to_string())
            }
            Content::Edits(_) => Err("edits are a file".into()),
        });
        let word = match found {
            Ok(found) => json!({ "is": is, "what": found }),
            Err(error) => json!({ "is": "error", "what": error }),
        };
        // Drop the answer if the page does not read its messages.
        let _ = words.try_send(word.to_string());
    });
}

/// Image that was sent last for a side, and is not shown yet.
struct Sent {
    serial: u64,
    look: Look,
    at: Instant,
}

/// Sends every change. Ends with the connection or with the program.
async fn speak(
    mut sink: SplitSink<WebSocket, Packet>,
    site: &Site,
    page: &RegisteredPage,
    mut words: mpsc::Receiver<String>,
    mut was_shown: watch::Receiver<u64>,
) -> Option<()> {
    let shared = &site.shared;
    let mut status = shared.status.subscribe();
    let mut holder = page.changes();
    let mut look = shared.look.subscribe();
    let [mut own, mut other] = [0, 1].map(|side: usize| shared.frames[side].subscribe());
    status.mark_changed();
    holder.mark_changed();
    let mut line = Line::new();
    // `on_its_way` is the image in transfer, `has` what the page shows on each side.
    let mut on_its_way: Option<Sent> = None;
    let mut has: [Option<(u64, Look)>; 2] = [None, None];
    loop {
        if on_its_way.is_none() {
            let wanted = *look.borrow_and_update();
            for (side, frames) in [&mut own, &mut other].into_iter().enumerate() {
                let Some(frame) = frames.borrow_and_update().clone() else {
                    if has[side].take().is_some() {
                        sink.send(Packet::text(json!({ "is": "gone", "side": side }).to_string()))
                            .await
                            .ok()?;
                    }
                    continue;
                };
                if on_its_way.is_some() || has[side] == Some((frame.serial, wanted)) {
                    continue;
                }
                let format = line.format();
                let serial = frame.serial;
                // A wait for a slot ends with its page, and takes no place in the queue of the threads.
                let turn = Arc::clone(&site.packers).acquire_owned().await.ok()?;
                let pack = move || {
                    let packet = packet(&frame, side, wanted, format);
                    drop(turn);
                    packet
                };
                let packet = spawn_blocking(pack).await.ok()?;
                has[side] = Some((serial, wanted));
                on_its_way = Some(Sent { serial, look: wanted, at: Instant::now() });
                sink.send(Packet::binary(packet)).await.ok()?;
            }
        }
        let waits = on_its_way.is_none();
        tokio::select! {
            word = words.recv() => sink.send(Packet::text(word?)).await.ok()?,
            changed = status.changed() => {
                changed.ok()?;
                let text = status.borrow_and_update().to_string();
                sink.send(Packet::text(text)).await.ok()?;
            }
            changed = holder.changed() => {
                changed.ok()?;
                holder.mark_unchanged();
                let word = json!({ "is": "control", "has_control": page.has_control(), "pages": page.pages() });
                sink.send(Packet::text(word.to_string())).await.ok()?;
            }
            changed = was_shown.changed() => {
                changed.ok()?;
                let serial = *was_shown.borrow_and_update();
                if let Some(sent) = on_its_way.take_if(|sent| sent.serial == serial) {
                    line.learn(sent.at.elapsed(), Instant::now());
                    debug_assert!(has.contains(&Some((sent.serial, sent.look))));
                }
            }
            changed = own.changed(), if waits => changed.ok()?,
            changed = other.changed(), if waits => changed.ok()?,
            changed = look.changed(), if waits => changed.ok()?,
        }
    }
}
