//! `view` as a process: the address that it prints is that of the page, and Ctrl-C ends it.

use super::*;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Stdio;

#[test]
fn the_printed_address_has_the_page_and_a_signal_ends_it() {
    let arguments = ["view", "preset:flat-bonded", "--set", "camera.pixels=[16, 12", "--json", "--backend", "cpu"];
    let refused = tirtouch(&arguments);
    // A list that does not end.
    assert_eq!(code(&refused), 2, "{refused:?}");
    let sets = ["--set", "camera.pixels[0]=16", "--set", "camera.pixels[1]=12"];
    let arguments = [&["view", "preset:flat-bonded", "--json", "--backend", "cpu"], &sets[..]].concat();
    let mut child = Command::new(env!("CARGO_BIN_EXE_tirtouch"))
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let url = serde_json::from_str::<Value>(&line).unwrap()["url"].as_str().unwrap().to_owned();
    let (address, path) = url.strip_prefix("http://").unwrap().split_once('/').unwrap();
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET /{path} HTTP/1.1\r\nhost: {address}\r\nconnection: close\r\n\r\n").unwrap();
    let mut page = String::new();
    stream.read_to_string(&mut page).unwrap();
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("flat-bonded"), "{page}");
    // SIGTERM, for what a shell starts in the background ignores SIGINT.
    let killed = Command::new("kill").arg(child.id().to_string()).status().unwrap();
    assert!(killed.success());
    let ended = child.wait_with_output().unwrap();
    assert_eq!((code(&ended), text(&ended.stderr)), (0, ""), "{ended:?}");
}

#[test]
fn what_cannot_be_shown_is_one_line() {
    for (arguments, said) in [
        (vec!["view", "preset:press-hertz", "--set", "press.indenter.radius_mm=-1"], "press"),
        (vec!["view", "preset:flat-bonded", "--slider", "stack.layer[9].n"], "no number of the scene"),
        (vec!["view", "preset:flat-bonded", "--slider", "stack.layer[0].n=2:1"], "FROM below TO"),
        (vec!["view", "preset:flat-bonded", "--tev", "127.0.0.1:1"], "no viewer takes images there"),
        (vec!["view", "no.toml"], "no.toml"),
    ] {
        let output = tirtouch(&arguments);
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(one_line(&output).contains(said), "{output:?}");
    }
}
