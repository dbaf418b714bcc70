//! Serves the page, its files, and its connection.

use std::sync::Arc;

use axum::body::{Body, Bytes};
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::http::header::{self, HeaderMap, HeaderName, HeaderValue};
use axum::middleware::{self, Next};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::get;
use axum::{Extension, Router};
use caustics::scene::EditsError;
use futures_util::stream;

use super::accept::ConnectionHandle;
use super::connection;
use super::shared::{Content, Query};
use super::site::Site;

/// Maximum length of a page's message (bytes).
const MAX_MESSAGE: usize = 64 << 10;
/// Maximum number of pages.
const MAX_PAGES: usize = 16;
/// Number of bytes of a file that are passed to a connection at once.
const PIECE: usize = 64 << 10;
/// Refusal of a connection above the maximum number.
const TOO_MANY: (StatusCode, &str) = (StatusCode::SERVICE_UNAVAILABLE, "too many connections; try again");

/// Returns all routes.
pub fn router(site: Arc<Site>) -> Router {
    Router::new()
        .route("/", get(page))
        .route("/connection", get(connect))
        .route("/image.exr", get(exr))
        .route("/image.png", get(png))
        .route("/edits.toml", get(edits))
        .route("/animation.toml", get(recording))
        .layer(middleware::from_fn_with_state(Arc::clone(&site), guarded))
        .with_state(site)
}

/// Refuses requests without the token, and forbids everything that the server's pages never need.
async fn guarded(
    State(site): State<Arc<Site>>,
    Extension(handle): Extension<ConnectionHandle>,
    request: Request,
    next: Next,
) -> Response {
    let refusal = site.guard.refuses(request.uri(), request.headers());
    let refusal = refusal.or_else(|| (!handle.show_token()).then_some(TOO_MANY));
    let mut response = match refusal {
        // Close the connection without waiting for a body or another request.
        Some(refusal) => ([(header::CONNECTION, "close")], refusal).into_response(),
        None => next.run(request).await,
    };
    let forbids: [(HeaderName, &str); 5] = [
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ];
    for (name, value) in forbids {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

async fn page(State(site): State<Arc<Site>>) -> Response {
    let policy = HeaderValue::from_str(site.page.policy());
    match policy {
        Ok(policy) => {
            ([(header::CONTENT_SECURITY_POLICY, policy)], Html(site.page.html().to_string())).into_response()
        }
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

async fn connect(State(site): State<Arc<Site>>, headers: HeaderMap, upgrade: WebSocketUpgrade) -> Response {
    // A browser always sends the origin of a page.
    if !headers.contains_key(header::ORIGIN) {
        return (StatusCode::FORBIDDEN, "a connection is for this server's page").into_response();
    }
    let Some(page) = site.control_token.register(MAX_PAGES) else {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open; close one").into_response();
    };
    let upgrade = upgrade.max_message_size(MAX_MESSAGE).max_frame_size(MAX_MESSAGE);
    upgrade.on_upgrade(move |socket| connection::run(socket, site, page))
}

async fn exr(State(site): State<Arc<Site>>) -> Response {
    file(&site, Query::Exr, "image/x-exr").await
}

async fn png(State(site): State<Arc<Site>>) -> Response {
    file(&site, Query::Png, "image/png").await
}

async fn edits(State(site): State<Arc<Site>>) -> Response {
    file(&site, Query::Edits, "application/toml").await
}

async fn recording(State(site): State<Arc<Site>>) -> Response {
    file(&site, Query::Recording, "application/toml").await
}

/// Sends a file of the renderer piece by piece.
async fn file(site: &Site, query: Query, kind: &'static str) -> Response {
    let failed = |error: String| (StatusCode::SERVICE_UNAVAILABLE, error).into_response();
    // Hold the permit until the file is sent: slow readers then keep few files in memory.
    let Ok(permit) = Arc::clone(&site.files).acquire_owned().await else {
        return failed("the program ends".into());
    };
    let content = match site.shared.ask(query) {
        Ok(answer) => answer.await.unwrap_or_else(|_| Err("the program ends".into())),
        Err(error) => Err(error),
    };
    let mut pieces: Box<dyn Iterator<Item = Result<Bytes, EditsError>> + Send> = match content {
        Ok(Content::Bytes(bytes)) => Box::new(pieces(bytes.into())),
        Ok(Content::Edits(edits)) => Box::new(edits.into_toml().map(|part| part.map(Bytes::from))),
        Err(error) => return failed(error),
    };
    let body = stream::iter(std::iter::from_fn(move || {
        let _held = &permit;
        pieces.next()
    }));
    ([(header::CONTENT_TYPE, kind)], Body::from_stream(body)).into_response()
}

/// Cuts a file into pieces.
fn pieces(mut bytes: Bytes) -> impl Iterator<Item = Result<Bytes, EditsError>> {
    std::iter::from_fn(move || {
        let size = bytes.len().min(PIECE);
        (size > 0).then(|| Ok(bytes.split_to(size)))
    })
}
