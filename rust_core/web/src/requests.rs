//! The HTTP requests: the page's files, the WebSocket, and the writes of the API.
//!
//! Paths are compared as a whole, never mapped to files, so there is nothing to traverse.

use std::convert::Infallible;
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;

use http_body_util::{BodyExt as _, Full, Limited};
use hyper::body::{Body as _, Bytes, Incoming};
use hyper::header::{self, HeaderMap, HeaderName, HeaderValue};
use hyper::{Method, Request, Response, StatusCode};
use serde_json::{json, Value};
use tokio::sync::Semaphore;
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::handshake::derive_accept_key;

use crate::access::{Access, Refused, PROTOCOL};
use crate::connections::Slot;
use crate::limits::Limits;
use crate::operator::{Operator, Refusal};
use crate::page_socket;
use crate::pages::Pages;

/// Most bytes of a request's body.
const MOST_BODY_BYTES: usize = 64 << 10;
/// Most requests that wait for a worker or are being carried out by one.
pub(crate) const MOST_REQUESTS: usize = 8;
const API: &str = "/api/";
const STREAM: &str = "/api/stream";

/// The page's files: path and content.
const FILES: [(&str, &[u8]); 12] = [
    ("/", include_bytes!("../page/index.html")),
    ("/page.css", include_bytes!("../page/page.css")),
    ("/camera.js", include_bytes!("../page/camera.js")),
    ("/displays.js", include_bytes!("../page/displays.js")),
    ("/elements.js", include_bytes!("../page/elements.js")),
    ("/light.js", include_bytes!("../page/light.js")),
    ("/node.js", include_bytes!("../page/node.js")),
    ("/nudge.js", include_bytes!("../page/nudge.js")),
    ("/page.js", include_bytes!("../page/page.js")),
    ("/settings.js", include_bytes!("../page/settings.js")),
    ("/shortcuts.js", include_bytes!("../page/shortcuts.js")),
    ("/show.js", include_bytes!("../page/show.js")),
];

/// Headers of all responses.
const HEADERS: [(HeaderName, &str); 5] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; img-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
];

/// The parts that all connections share.
pub(crate) struct Site {
    pub(crate) access: Access,
    pub(crate) operator: Arc<dyn Operator>,
    pub(crate) pages: Pages,
    pub(crate) limits: Limits,
    /// One permit for each request that a worker may have.
    pub(crate) workers: Arc<Semaphore>,
}

type Answer = Response<Full<Bytes>>;

/// Answers a request.
pub(crate) async fn answer(site: Arc<Site>, peer: IpAddr, request: Request<Incoming>) -> Result<Answer, Infallible> {
    let answered = route(&site, peer, request).await;
    let mut response = answered.unwrap_or_else(|(status, why)| json_answer(status, &why));
    for (name, value) in HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    Ok(response)
}

async fn route(site: &Arc<Site>, peer: IpAddr, request: Request<Incoming>) -> Result<Answer, Refused> {
    site.access.check_host(request.headers())?;
    let path = request.uri().path();
    if path == STREAM {
        allow(&request, &[Method::GET])?;
        return open_stream(site, peer, request);
    }
    if let Some(name) = path.strip_prefix(API) {
        allow(&request, &[Method::POST])?;
        let name = name.to_owned();
        return post(site, peer, &name, request).await;
    }
    let file = FILES.iter().find(|(known, _)| *known == path);
    let (path, content) = file.ok_or((StatusCode::NOT_FOUND, "there is nothing at this address".to_owned()))?;
    allow(&request, &[Method::GET, Method::HEAD])?;
    let mut response = Response::new(Full::new(Bytes::from_static(content)));
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(kind_of(path)));
    Ok(response)
}

/// The type of a file.
fn kind_of(path: &str) -> &'static str {
    match path.rsplit_once('.') {
        Some((_, "js")) => "text/javascript; charset=utf-8",
        Some((_, "css")) => "text/css; charset=utf-8",
        _ => "text/html; charset=utf-8",
    }
}

fn allow(request: &Request<Incoming>, methods: &[Method]) -> Result<(), Refused> {
    if methods.contains(request.method()) {
        return Ok(());
    }
    let methods: Vec<_> = methods.iter().map(Method::as_str).collect();
    let why = format!("{} is not possible here, {} is", request.method(), methods.join(" or "));
    Err((StatusCode::METHOD_NOT_ALLOWED, why))
}

/// An answer of the API.
fn json_answer(status: StatusCode, message: &str) -> Answer {
    let body = json!({"ok": status.is_success(), "message": message}).to_string();
    let mut response = Response::new(Full::new(Bytes::from(body)));
    *response.status_mut() = status;
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
    response
}

/// Answers the handshake of a page's WebSocket, and serves it from then on.
fn open_stream(site: &Arc<Site>, peer: IpAddr, mut request: Request<Incoming>) -> Result<Answer, Refused> {
    let headers = request.headers();
    site.access.check_origin(headers)?;
    site.access.check_protocols(headers)?;
    let slot = admitted(&request)?;
    let is_upgrade =
        has_word(headers, &header::UPGRADE, "websocket") && has_word(headers, &header::CONNECTION, "upgrade");
    let is_version = headers.get(header::SEC_WEBSOCKET_VERSION).is_some_and(|version| version == "13");
    let key = headers.get(header::SEC_WEBSOCKET_KEY).filter(|_| is_upgrade && is_version);
    let key = key.ok_or((StatusCode::UPGRADE_REQUIRED, "this address is a WebSocket, version 13".to_owned()))?;
    let accept = HeaderValue::from_str(&derive_accept_key(key.as_bytes()));
    let accept = accept.map_err(|error| (StatusCode::BAD_REQUEST, error.to_string()))?;
    let upgrade = hyper::upgrade::on(&mut request);
    let site = Arc::clone(site);
    tokio::spawn(async move {
        let _slot = slot;
        // Fails if the client leaves before.
        if let Ok(upgraded) = upgrade.await {
            page_socket::serve(upgraded, &caller(peer), &site).await;
        }
    });
    let mut response = Response::new(Full::default());
    *response.status_mut() = StatusCode::SWITCHING_PROTOCOLS;
    let headers = response.headers_mut();
    headers.insert(header::UPGRADE, HeaderValue::from_static("websocket"));
    headers.insert(header::CONNECTION, HeaderValue::from_static("Upgrade"));
    headers.insert(header::SEC_WEBSOCKET_ACCEPT, accept);
    headers.insert(header::SEC_WEBSOCKET_PROTOCOL, HeaderValue::from_static(PROTOCOL));
    Ok(response)
}

/// Returns `true` if a header's list has this word.
fn has_word(headers: &HeaderMap, name: &HeaderName, word: &str) -> bool {
    let values = headers.get_all(name).iter().filter_map(|value| value.to_str().ok());
    values.flat_map(|value| value.split(',')).any(|listed| listed.trim().eq_ignore_ascii_case(word))
}

/// Moves a connection that has shown the token to those that have, and returns its slot.
fn admitted(request: &Request<Incoming>) -> Result<Arc<Slot>, Refused> {
    let slot = request.extensions().get::<Arc<Slot>>().filter(|slot| slot.admit());
    let full = || (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open; close some".to_owned());
    slot.map(Arc::clone).ok_or_else(full)
}

/// The name of a page in logs.
fn caller(peer: IpAddr) -> String {
    format!("the page at {peer}")
}

/// Has a request of the API carried out.
async fn post(site: &Arc<Site>, peer: IpAddr, name: &str, request: Request<Incoming>) -> Result<Answer, Refused> {
    site.access.check_origin(request.headers())?;
    site.access.check_bearer(request.headers())?;
    admitted(&request)?;
    let kind = request.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
    if kind.split(';').next().map(str::trim) != Some("application/json") {
        return Err((StatusCode::UNSUPPORTED_MEDIA_TYPE, "the body must be application/json".to_owned()));
    }
    let body = read_body(request.into_body(), site.limits.body).await?;
    let caller = caller(peer);
    let result = if site.operator.is_immediate(name) {
        site.operator.post(name, &body, &caller)
    } else {
        let permit = Arc::clone(&site.workers).try_acquire_owned();
        let busy = |_| (StatusCode::SERVICE_UNAVAILABLE, "too many requests wait; try again".to_owned());
        let (permit, operator, name) = (permit.map_err(busy)?, Arc::clone(&site.operator), name.to_owned());
        let working = tokio::task::spawn_blocking(move || {
            let result = operator.post(&name, &body, &caller);
            drop(permit);
            result
        });
        working.await.unwrap_or_else(|_| Err(Refusal::Failed("the request failed; see the node's log".to_owned())))
    };
    site.pages.state_changed();
    match result {
        Ok(message) => Ok(json_answer(StatusCode::OK, &message)),
        Err(refusal) => {
            let status = match &refusal {
                Refusal::Unknown(_) => StatusCode::NOT_FOUND,
                Refusal::Invalid(_) => StatusCode::BAD_REQUEST,
                Refusal::Failed(_) => StatusCode::CONFLICT,
            };
            Err((status, refusal.to_string()))
        }
    }
}

/// Reads a body within the limits of size and time.
async fn read_body(body: Incoming, limit: Duration) -> Result<Value, Refused> {
    let too_large = || (StatusCode::PAYLOAD_TOO_LARGE, format!("the body is larger than {MOST_BODY_BYTES} bytes"));
    if body.size_hint().lower() > MOST_BODY_BYTES as u64 {
        return Err(too_large());
    }
    let read = timeout(limit, Limited::new(body, MOST_BODY_BYTES).collect()).await;
    let read = read.map_err(|_| (StatusCode::REQUEST_TIMEOUT, "the body took too long".to_owned()))?;
    let body = read.map_err(|error| match error.downcast_ref() {
        Some(http_body_util::LengthLimitError { .. }) => too_large(),
        None => (StatusCode::BAD_REQUEST, format!("the body cannot be read: {error}")),
    })?;
    let body = serde_json::from_slice::<Value>(&body.to_bytes()).ok().filter(Value::is_object);
    body.ok_or((StatusCode::BAD_REQUEST, "the body is no JSON object".to_owned()))
}
