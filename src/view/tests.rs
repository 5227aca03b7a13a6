//! The page's server against requests of all kinds, and the painter against a render.

#![allow(clippy::unwrap_used)]

use super::{Desk, Knob, Server, paint};
use crate::pipeline::{Order, Session};
use crate::scene::{LoadedScene, Scene, preset};
use crate::streams::Role;
use crate::trace::{Devices, Precision, Settings};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// A scene that traces in a moment.
fn small() -> LoadedScene {
    let mut loaded = preset("contact-disc").unwrap();
    let keys = ["camera.pixels[0]=24", "camera.pixels[1]=18", "render.spp=64", "render.photons=20000"];
    let sets: Vec<_> = keys.iter().map(|key| key.parse().unwrap()).collect();
    loaded = crate::vary::with(loaded, Path::new("disc.toml"), &sets).unwrap();
    loaded
}

/// A served desk, without a painter.
struct Served {
    desk: Arc<Desk>,
    address: String,
    token: String,
    ends: Arc<AtomicBool>,
    thread: Option<thread::JoinHandle<()>>,
}

impl Served {
    fn new() -> Self {
        let loaded = small();
        let knobs = Knob::of(&loaded, Path::new("disc.toml"), &[]).unwrap();
        let desk = Arc::new(Desk::new(loaded, "disc.toml".into()));
        let server = Server::open(desk.clone(), &knobs, 0).unwrap();
        let url = server.url();
        let (address, token) = url.strip_prefix("http://").unwrap().split_once("/?token=").unwrap();
        let (address, token) = (address.to_owned(), token.to_owned());
        let ends = Arc::new(AtomicBool::new(false));
        let seen = ends.clone();
        let thread = thread::spawn(move || server.serve(&|| seen.load(Ordering::Relaxed)));
        Self { desk, address, token, ends, thread: Some(thread) }
    }

    /// What comes back for raw bytes; nothing where the connection is closed. `breaks_off`: no more will be sent.
    fn raw(&self, request: &[u8], breaks_off: bool) -> Vec<u8> {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        // A server that has refused may close before it has read all.
        let _ = stream.write_all(request);
        if breaks_off {
            let _ = stream.shutdown(Shutdown::Write);
        }
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        answer
    }

    /// Status and body for a request with these lines after the first, and a body.
    fn ask(&self, first: &str, headers: &[&str], body: &str) -> (u16, String) {
        let headers: String = headers.iter().map(|line| format!("{line}\r\n")).collect();
        let length = body.len();
        let text = format!("{first} HTTP/1.1\r\n{headers}connection: close\r\ncontent-length: {length}\r\n\r\n{body}");
        let answer = String::from_utf8_lossy(&self.raw(text.as_bytes(), false)).into_owned();
        let status = answer.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
        (status, answer.split_once("\r\n\r\n").map_or_else(String::new, |(_, body)| body.to_owned()))
    }

    fn host(&self) -> String {
        format!("host: {}", self.address)
    }

    fn get(&self, path: &str) -> (u16, String) {
        let dot = if path.contains('?') { '&' } else { '?' };
        self.ask(&format!("GET {path}{dot}token={}", self.token), &[&self.host()], "")
    }

    fn wish(&self, body: &str) -> (u16, Value) {
        let (status, body) = self.ask(&format!("POST /wish?token={}", self.token), &[&self.host()], body);
        (status, serde_json::from_str(&body).unwrap_or(Value::Null))
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        self.thread.take().map(thread::JoinHandle::join);
    }
}

#[test]
fn the_page_holds_all_that_it_needs_and_no_other_address() {
    let served = Served::new();
    let (status, page) = served.get("/");
    assert_eq!(status, 200);
    assert!(page.contains("stack.layer[0].n") && page.contains("</html>"), "{page}");
    // No address but those of names in a document.
    assert!(!page.contains("http://") && !page.contains("https://"), "{page}");
}

#[test]
fn only_this_machine_with_the_token_is_answered() {
    let served = Served::new();
    let with_token = format!("GET /?token={}", served.token);
    let host = served.host();
    let port = served.address.split_once(':').unwrap().1;
    let mut wrong = served.token.clone();
    wrong.replace_range(0..1, if wrong.starts_with('0') { "1" } else { "0" });
    for (first, headers) in [
        ("GET /".to_owned(), vec![host.clone()]),
        ("GET /?token=".to_owned(), vec![host.clone()]),
        (format!("GET /?token={wrong}"), vec![host.clone()]),
        (format!("GET /scene.toml?token={wrong}"), vec![host.clone()]),
        (with_token.clone(), vec!["host: example.org".to_owned()]),
        (with_token.clone(), vec![format!("host: example.org:{port}")]),
        (with_token.clone(), vec!["host: 127.0.0.1".to_owned()]),
        (with_token.clone(), vec!["host:".to_owned()]),
        (with_token.clone(), vec![host.clone(), "host: example.org".to_owned()]),
        (with_token.clone(), vec![]),
        (with_token.clone(), vec![host.clone(), "origin: http://example.org".to_owned()]),
        (with_token.clone(), vec![host.clone(), "origin: null".to_owned()]),
        (with_token.clone(), vec![host.clone(), format!("origin: https://{}", served.address)]),
    ] {
        let headers: Vec<&str> = headers.iter().map(String::as_str).collect();
        assert_eq!(served.ask(&first, &headers, "").0, 403, "{first} {headers:?}");
    }
    for headers in [
        vec![host.clone()],
        vec![format!("Host: LOCALHOST:{port}")],
        vec![host, format!("origin: http://{}", served.address)],
    ] {
        let headers: Vec<&str> = headers.iter().map(String::as_str).collect();
        assert_eq!(served.ask(&with_token, &headers, "").0, 200, "{headers:?}");
    }
}

#[test]
fn a_wish_changes_the_scene_or_says_why_not() {
    let served = Served::new();
    let (status, answer) = served.wish(r#"{"stack.layer[0].n": 1.43}"#);
    assert_eq!((status, &answer), (200, &json!({"wish": 2})));
    let (_, text) = served.get("/scene.toml");
    let scene: Scene = toml::from_str(&text).unwrap();
    assert_eq!(scene.stack.layer[0].n, Some(1.43));
    for (body, status, said) in [
        (r#"{"stack.layer[0].n": -1}"#, 422, "stack.layer[0].n"),
        (r#"{"stack.layer[9].n": 1.4}"#, 422, "stack.layer[9].n"),
        (r#"{"no..key": 1.4}"#, 422, "no..key"),
        (r#"{"stack.layer[0].n": "1.4"}"#, 400, "invalid type"),
        ("[1]", 400, "invalid type"),
        ("{", 400, "EOF"),
    ] {
        let (found, answer) = served.wish(body);
        assert_eq!(found, status, "{body}: {answer}");
        assert!(answer.to_string().contains(said), "{body}: {answer}");
    }
    assert_eq!(served.wish(&format!("{{\"a\": {}1}}", " ".repeat(1 << 20))).0, 413);
    let many: BTreeMap<String, f64> = (0..1001).map(|k| (format!("k{k}"), 1.0)).collect();
    assert_eq!(served.wish(&json!(many).to_string()).0, 413);
    served.desk.show(|_| ());
    // What was refused has changed nothing; a page that is opened now learns what was wished for.
    let seen: Value = serde_json::from_str(&served.get("/seen?after=0").1).unwrap();
    assert_eq!(seen["latest"], json!({"wish": 2, "values": {"stack.layer[0].n": 1.43}}));
    // No numbers are those of the file.
    assert_eq!(served.get("/scene.toml").1, text);
    assert_eq!(served.wish("{}").1, json!({"wish": 3}));
    assert_eq!(served.get("/scene.toml").1, small().text);
}

#[test]
fn news_come_at_once_and_old_news_wait_for_newer_ones() {
    let served = Served::new();
    served.desk.show(|seen| seen.what = "one".into());
    let (status, seen) = served.get("/seen?after=0");
    let seen: Value = serde_json::from_str(&seen).unwrap();
    assert_eq!((status, &seen["what"], &seen["look"]), (200, &json!("one"), &Value::Null));
    thread::scope(|scope| {
        let waits = scope.spawn(|| served.get(&format!("/seen?after={}", seen["revision"])).1);
        served.desk.show(|seen| seen.what = "two".into());
        assert!(waits.join().unwrap().contains("two"));
    });
    assert_eq!([served.get("/pixels").0, served.get("/side.svg").0], [404, 404]);
}

#[test]
fn ten_thousand_bad_requests_are_refused_and_the_page_is_there_after_them() {
    let served = Served::new();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state >> 33
    };
    let (token, host) = (&served.token, served.host());
    // Requests that are none, or break off: a refusal, or the end of the connection.
    let broken: [&dyn Fn(u64) -> Vec<u8>; 4] = [
        &|seed| (0..seed % 300).map(|k| (seed.wrapping_mul(k + 1) >> 3) as u8).collect(),
        &|seed| format!("GET /?token={token} HTTP/1.1\r\n{host}\r\nx: {}", "a".repeat((seed % 40_000) as usize)).into(),
        &|seed| format!("POST /wish?token={token} HTTP/1.1\r\n{host}\r\ncontent-length: {}\r\n\r\n{{", seed + 2).into(),
        &|seed| {
            let head = format!("POST /wish?token={token} HTTP/1.1\r\n{host}\r\ntransfer-encoding: chunked\r\n");
            format!("{head}\r\n{:x}\r\n{{", seed + 2).into()
        },
    ];
    // Whole ones that ask for what is not there: a refusal.
    let close = format!("HTTP/1.1\r\n{host}\r\nconnection: close\r\n");
    let whole: [&dyn Fn(u64) -> Vec<u8>; 6] = [
        &|seed| format!("GET /{seed} {close}\r\n").into(),
        &|seed| format!("GET /../{seed}?token={token} {close}\r\n").into(),
        &|seed| format!("GET /?token={seed:032x} {close}\r\n").into(),
        &|seed| format!("DELETE /wish?token={token}&{seed} {close}\r\n").into(),
        &|seed| {
            let body = format!("{{\"stack.layer[{seed}].n\": 1}}");
            format!("POST /wish?token={token} {close}content-length: {}\r\n\r\n{body}", body.len()).into()
        },
        &|seed| format!("GET /?token={token} HTTP/1.1\r\nhost: {seed}\r\nconnection: close\r\n\r\n").into(),
    ];
    for k in 0..1000 {
        for (request, breaks_off) in
            broken.iter().map(|request| (request, true)).chain(whole.iter().map(|request| (request, false)))
        {
            let request = request(random());
            let answer = served.raw(&request, breaks_off);
            let status = String::from_utf8_lossy(&answer).split(' ').nth(1).and_then(|status| status.parse().ok());
            let refused = status.map_or(breaks_off, |status: u16| (400..500).contains(&status));
            assert!(refused, "{k}: {status:?} {:?}", String::from_utf8_lossy(&request));
        }
    }
    assert_eq!(served.get("/").0, 200);
    assert_eq!(served.get("/scene.toml").1, small().text);
}

/// Waits for what the painter shows.
fn wait(desk: &Desk, is_it: impl FnMut(&super::Seen) -> bool) -> super::Seen {
    let mut seen = desk.seen();
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    runtime.block_on(seen.wait_for(is_it)).unwrap().clone()
}

#[test]
fn the_last_image_of_each_wish_is_that_of_a_render() {
    let desk = Arc::new(Desk::new(small(), "disc.toml".into()));
    let painter = {
        let desk = desk.clone();
        thread::spawn(move || {
            paint(Devices::cpu(Precision::F32).into(), &desk, &|scene| Settings::of(&scene.render), None);
        })
    };
    for (wish, n) in [(1, None), (2, Some(1.45))] {
        let values: BTreeMap<_, _> = n.map(|n| ("touch.contact.tissue.n".to_owned(), n)).into_iter().collect();
        if n.is_some() {
            assert_eq!(desk.wish(&values).unwrap(), wish);
        }
        let seen = wait(&desk, |seen| seen.wish == wish && !seen.busy);
        let look = seen.look.unwrap();
        assert!(seen.error.is_none() && look.is_last && look.wish == wish);

        let sets: Vec<_> = n.map(|n| format!("touch.contact.tissue.n={n}").parse().unwrap()).into_iter().collect();
        let loaded = crate::vary::with(small(), Path::new("disc.toml"), &sets).unwrap();
        let mut session = Session::from(Devices::cpu(Precision::F32));
        let order = Order::of(&loaded.scene);
        let prepared = session.prepare(loaded, &order, &mut |_| true).unwrap();
        assert_eq!(prepared.streams.role, Role::Image);
        let shot = session.shoot(&prepared, &mut |_| true).unwrap();
        let film = &shot.outcome.film;
        let floats = |from: usize| {
            let bytes = &look.pixels[12 + 2 * film.mean.len() + 4 * from * film.mean.len()..];
            let numbers = bytes.chunks_exact(4).take(film.mean.len());
            numbers.map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect::<Vec<_>>()
        };
        assert_eq!(look.pixels[..12], [[24u32, 18, 255].map(u32::to_le_bytes).concat()].concat());
        assert_eq!(floats(0), film.mean);
        let errors: Vec<f32> = shot.outcome.unseen.variances(film).into_iter().map(f32::sqrt).collect();
        assert_eq!(floats(1), errors);
        let grey: Vec<u16> =
            look.pixels[12..].chunks_exact(2).take(film.mean.len()).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
        assert_eq!(grey, shot.frame.grey);
        assert_eq!(look.said["ledger"], json!(shot.outcome.ledger));
    }
    desk.end();
    painter.join().unwrap();
}

#[test]
fn a_new_wish_stops_the_work_on_the_old_one() {
    let mut loaded = small();
    loaded.scene.render.spp = 1 << 24;
    let desk = Arc::new(Desk::new(loaded, "disc.toml".into()));
    let painter = {
        let desk = desk.clone();
        // The first wish would take hours.
        let settings = |scene: &Scene| Settings::of(&scene.render);
        thread::spawn(move || paint(Devices::cpu(Precision::F32).into(), &desk, &settings, None))
    };
    wait(&desk, |seen| seen.wish == 1 && seen.look.is_some());
    let numbers = BTreeMap::from([("render.spp".to_owned(), 16.0)]);
    assert_eq!(desk.wish(&numbers).unwrap(), 2);
    let seen = wait(&desk, |seen| seen.wish == 2 && !seen.busy);
    assert!(seen.error.is_none() && seen.look.is_some_and(|look| look.wish == 2));
    desk.end();
    painter.join().unwrap();
}
