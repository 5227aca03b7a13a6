//! Answers the page.

use super::desk::{Desk, Seen};
use super::knob::Knob;
use super::tokens::Token;
use crate::report::color_of;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{self, HeaderValue};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::net::Ipv4Addr;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;
use tokio::time::timeout;

/// Connections at a time; a page has six.
const MOST_CONNECTIONS: usize = 64;
/// Numbers of a wish: a scene has a few hundred, and each is looked for in its text.
const MOST_NUMBERS: usize = 1000;
/// Bytes of a request's head and of its body.
const MOST_HEAD: usize = 16 << 10;
const MOST_BODY: usize = 64 << 10;
/// Time for a request to arrive.
const PATIENCE: Duration = Duration::from_secs(3);
/// Time after which a page that waits for news is told that there are none.
const NEWS: Duration = Duration::from_secs(20);
/// Time between two looks whether it is the end.
const BETWEEN_LOOKS: Duration = Duration::from_millis(100);

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// No server.
#[derive(Debug, Error)]
pub enum ViewError {
    /// The port is taken, or not ours.
    #[error("port {port} of 127.0.0.1 cannot be listened at: {cause}")]
    Port {
        /// The port asked for.
        port: u16,
        /// What the system says.
        cause: std::io::Error,
    },
    /// No random numbers, no threads.
    #[error("the page cannot be served: {0}")]
    System(#[from] std::io::Error),
    /// A slider for what is no number.
    #[error("{0}")]
    Knob(String),
}

/// A server of one page.
pub struct Server {
    runtime: tokio::runtime::Runtime,
    listener: TcpListener,
    host: Arc<Host>,
    port: u16,
}

/// What every request needs.
struct Host {
    desk: Arc<Desk>,
    token: Token,
    page: Bytes,
    policy: HeaderValue,
    /// Names that this server goes by, with its port.
    names: [String; 2],
}

impl Server {
    /// Listens on the loopback address, at a free port for 0.
    ///
    /// # Errors
    /// A port that cannot be had; a system without random numbers.
    pub fn open(desk: Arc<Desk>, knobs: &[Knob], port: u16) -> Result<Self, ViewError> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build()?;
        let listener = runtime.block_on(TcpListener::bind((Ipv4Addr::LOCALHOST, port)));
        let listener = listener.map_err(|cause| ViewError::Port { port, cause })?;
        let port = listener.local_addr()?.port();
        let scene = &desk.base().scene;
        let told = json!({"name": scene.name, "description": scene.description, "knobs": knobs, "colors": colors()});
        // What stands in a script must not end it.
        let told = told.to_string().replace('<', "\\u003c");
        let script = format!("const told = {told};\n{SCRIPT}");
        let page = PAGE.replace("/*style*/", STYLE).replace("/*script*/", &script);
        let hash = |text: &str| STANDARD.encode(Sha256::digest(text.as_bytes()));
        let policy = format!(
            "default-src 'none'; connect-src 'self'; img-src blob: data:; script-src 'sha256-{}'; \
             style-src 'sha256-{}'",
            hash(&script),
            hash(STYLE)
        );
        let policy = HeaderValue::from_str(&policy).map_err(std::io::Error::other)?;
        let names = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
        let host = Arc::new(Host { desk, token: Token::draw()?, page: page.into(), policy, names });
        Ok(Self { runtime, listener, host, port })
    }

    /// The address of the page, with its token.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/?token={}", self.port, self.host.token.text())
    }

    /// Answers until `ends` says that it is the end.
    pub fn serve(&self, ends: &dyn Fn() -> bool) {
        let room = Arc::new(Semaphore::new(MOST_CONNECTIONS));
        self.runtime.block_on(async {
            while !ends() {
                // None within this time, or one that broke off before it was taken: the next.
                let Ok(Ok((stream, _))) = timeout(BETWEEN_LOOKS, self.listener.accept()).await else { continue };
                // Too many: this one is closed.
                let Ok(place) = room.clone().try_acquire_owned() else { continue };
                let host = self.host.clone();
                tokio::spawn(async move {
                    let service = service_fn(|request| answer(request, host.clone()));
                    // What is no request, or breaks off, ends its connection and nothing else.
                    let _ = http1::Builder::new()
                        .timer(TokioTimer::new())
                        .header_read_timeout(PATIENCE)
                        .max_buf_size(MOST_HEAD)
                        .serve_connection(TokioIo::new(stream), service)
                        .await;
                    drop(place);
                });
            }
        });
    }
}

/// The colours of pictures from dark to bright, each as six hexadecimal digits.
fn colors() -> String {
    (0..=255u8)
        .map(|level| color_of(f64::from(level) / 255.0))
        .map(|[red, green, blue]| format!("{red:02x}{green:02x}{blue:02x}"))
        .collect()
}

type Answer = Response<Full<Bytes>>;

async fn answer(request: Request<Incoming>, host: Arc<Host>) -> Result<Answer, Infallible> {
    let mut answer = match refusal(&request, &host) {
        Some((status, why)) => plain(status, why),
        None => route(request, &host).await,
    };
    let headers = answer.headers_mut();
    let keep = |name, value| (name, HeaderValue::from_static(value));
    headers.extend([
        keep(header::CACHE_CONTROL, "no-store"),
        keep(header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        keep(header::REFERRER_POLICY, "no-referrer"),
        keep(header::X_FRAME_OPTIONS, "DENY"),
        (header::CONTENT_SECURITY_POLICY, host.policy.clone()),
    ]);
    Ok(answer)
}

/// Why a request is not answered: it is for another host, from another page, or without the token.
fn refusal(request: &Request<Incoming>, host: &Host) -> Option<(StatusCode, &'static str)> {
    let is_name = |name: &str| host.names.iter().any(|ours| ours.eq_ignore_ascii_case(name));
    let header = |name| request.headers().get(name).map(|value: &HeaderValue| value.to_str().unwrap_or(""));
    if request.headers().get_all(header::HOST).iter().count() != 1 || !header(header::HOST).is_some_and(is_name) {
        return Some((StatusCode::FORBIDDEN, "this server answers to no such host"));
    }
    let from_us = |origin: &str| origin.strip_prefix("http://").is_some_and(is_name);
    if !header(header::ORIGIN).is_none_or(from_us) {
        return Some((StatusCode::FORBIDDEN, "this server answers its own page alone"));
    }
    let token = query(request, "token").unwrap_or("");
    (!host.token.is(token)).then_some((StatusCode::FORBIDDEN, "the token of the page's address is missing or wrong"))
}

/// A value of the query, as it stands there.
fn query<'r>(request: &'r Request<Incoming>, name: &str) -> Option<&'r str> {
    let pairs = request.uri().query()?.split('&').filter_map(|pair| pair.split_once('='));
    pairs.filter(|(key, _)| *key == name).map(|(_, value)| value).next()
}

async fn route(request: Request<Incoming>, host: &Host) -> Answer {
    let desk = &host.desk;
    match (request.method(), request.uri().path()) {
        (&Method::GET, "/") => of_kind("text/html; charset=utf-8", host.page.clone()),
        (&Method::GET, "/seen") => seen(&request, desk).await,
        (&Method::GET, "/pixels") => look(desk, |look| of_kind("application/octet-stream", look.pixels.clone())),
        (&Method::GET, "/side.svg") => look(desk, |look| of_kind("image/svg+xml", look.side.clone())),
        (&Method::GET, "/scene.toml") => of_kind("application/toml", desk.text()),
        (&Method::POST, "/wish") => wish(request, desk).await,
        (_, "/" | "/seen" | "/pixels" | "/side.svg" | "/scene.toml" | "/wish") => {
            plain(StatusCode::METHOD_NOT_ALLOWED, "no such method here")
        }
        _ => plain(StatusCode::NOT_FOUND, "nothing is here"),
    }
}

/// What there is to see, once that is newer than what the page has seen.
async fn seen(request: &Request<Incoming>, desk: &Desk) -> Answer {
    let after: u64 = query(request, "after").and_then(|after| after.parse().ok()).unwrap_or(0);
    let mut seen = desk.seen();
    let newer = async { seen.wait_for(|seen| seen.revision > after).await.map(|seen| seen.clone()) };
    let news = timeout(NEWS, newer).await;
    match news {
        Ok(Ok(seen)) => json_of(StatusCode::OK, &told(desk, &seen)),
        _ => json_of(StatusCode::OK, &told(desk, &desk.seen().borrow())),
    }
}

fn told(desk: &Desk, seen: &Seen) -> Value {
    let mut told = json!(seen);
    // Another page may have wished for it, or this one before it was loaded again.
    let (number, values) = desk.latest();
    told["latest"] = json!({"wish": number, "values": values});
    told["look"] = match &seen.look {
        Some(look) => json!({"wish": look.wish, "step": look.step, "is_last": look.is_last, "said": look.said}),
        None => Value::Null,
    };
    told
}

fn look(desk: &Desk, answer: impl FnOnce(&super::look::Look) -> Answer) -> Answer {
    let look = desk.seen().borrow().look.clone();
    look.map_or_else(|| plain(StatusCode::NOT_FOUND, "there is no image yet"), |look| answer(&look))
}

/// Wishes for the scene with the numbers of the body, `{"key": number}`.
async fn wish(request: Request<Incoming>, desk: &Desk) -> Answer {
    let body = timeout(PATIENCE, Limited::new(request.into_body(), MOST_BODY).collect()).await;
    let Ok(Ok(body)) = body else {
        return plain(StatusCode::PAYLOAD_TOO_LARGE, "the body is too large, or did not arrive");
    };
    let values: BTreeMap<String, f64> = match serde_json::from_slice(&body.to_bytes()) {
        Ok(values) => values,
        Err(error) => {
            let why = json!({"message": format!("the body must be {{\"key\": number}}: {error}"), "key": null});
            return json_of(StatusCode::BAD_REQUEST, &json!({"error": why}));
        }
    };
    if values.len() > MOST_NUMBERS {
        return plain(StatusCode::PAYLOAD_TOO_LARGE, "no scene has so many numbers");
    }
    match desk.wish(&values) {
        Ok(number) => json_of(StatusCode::OK, &json!({"wish": number})),
        Err(error) => {
            let why = json!({"message": error.message, "key": error.key});
            json_of(StatusCode::UNPROCESSABLE_ENTITY, &json!({"error": why}))
        }
    }
}

fn of_kind(kind: &'static str, body: impl Into<Bytes>) -> Answer {
    let mut answer = Response::new(Full::new(body.into()));
    answer.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
    answer
}

fn plain(status: StatusCode, words: &'static str) -> Answer {
    let mut answer = of_kind("text/plain; charset=utf-8", words);
    *answer.status_mut() = status;
    answer
}

fn json_of(status: StatusCode, value: &Value) -> Answer {
    let mut answer = of_kind("application/json", value.to_string());
    *answer.status_mut() = status;
    answer
}
