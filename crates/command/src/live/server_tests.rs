//! Tests of the server over real connections on this computer.

use crate::live::server::{Ended, Server};
use crate::live::session::Session;
use crate::live::tests::started;
use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tungstenite::protocol::Role;
use tungstenite::{Message, WebSocket};

/// Server that runs a supplied wing model in a thread.
struct Served {
    port: u16,
    token: String,
    interrupted: Arc<AtomicBool>,
    thread: Option<JoinHandle<Ended>>,
}

const TIMEOUT: Duration = Duration::from_secs(60);

impl Served {
    fn new(grace: Duration) -> Self {
        let server = Server::bind(0).unwrap().with_grace(grace);
        let (port, address) = (server.port(), server.address());
        let token = address.trim_end_matches('/').rsplit('/').next().unwrap().to_owned();
        assert_eq!(address, format!("http://127.0.0.1:{port}/{token}/"));
        let interrupted = Arc::new(AtomicBool::new(false));
        let heard = Arc::clone(&interrupted);
        let thread = std::thread::spawn(move || {
            let (interface, plant) = started("folding_wing");
            server.run(&mut Session::new(plant, interface, 1.0), &heard).unwrap()
        });
        Self { port, token, interrupted, thread: Some(thread) }
    }

    fn connected(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(TIMEOUT)).unwrap();
        stream
    }

    /// Returns the complete response to a request.
    fn answer(&self, request: &str) -> String {
        let mut stream = self.connected();
        stream.write_all(request.as_bytes()).unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text
    }

    fn request(&self, path: &str, headers: &str) -> String {
        format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n{headers}\r\n", self.port)
    }

    fn upgrade(&self, token: &str, origin: &str) -> String {
        let headers = format!(
            "Origin: {origin}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
             Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        );
        self.request(&format!("/{token}/socket"), &headers)
    }

    fn origin(&self) -> String {
        format!("http://127.0.0.1:{}", self.port)
    }

    /// Opens the WebSocket of a page.
    fn page(&self) -> WebSocket<TcpStream> {
        let mut stream = self.connected();
        stream.write_all(self.upgrade(&self.token, &self.origin()).as_bytes()).unwrap();
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap();
            head.push(byte[0]);
        }
        let head = String::from_utf8(head).unwrap();
        assert!(head.starts_with("HTTP/1.1 101 ") && head.contains("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), "{head}");
        WebSocket::from_raw_socket(stream, Role::Client, None)
    }

    fn ended(&mut self) -> Ended {
        self.thread.take().unwrap().join().unwrap()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.interrupted.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Returns the next text message of a kind.
fn told(page: &mut WebSocket<TcpStream>, kind: &str) -> Value {
    loop {
        if let Message::Text(text) = page.read().unwrap() {
            let value: Value = serde_json::from_str(&text).unwrap();
            if value["kind"] == kind {
                return value;
            }
        }
    }
}

/// Returns the header of the first frame that satisfies a condition.
fn header_of_frame(page: &mut WebSocket<TcpStream>, fits: impl Fn(&Value) -> bool) -> Value {
    loop {
        if let Message::Binary(bytes) = page.read().unwrap() {
            let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
            let header: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
            if fits(&header) {
                return header;
            }
        }
    }
}

/// Without the token, from another origin or with another host name, neither page nor WebSocket is served; if all three are right, both
/// are.
#[test]
fn wrong_tokens_and_foreign_origins_are_refused() {
    let mut served = Served::new(Duration::from_millis(50));
    let (token, origin) = (served.token.clone(), served.origin());
    let foreign = "http://evil.example";
    let elsewhere = format!("GET /{token}/ HTTP/1.1\r\nHost: evil.example:{}\r\n\r\n", served.port);
    for request in [
        served.request("/", ""),
        served.request("/0123456789abcdef0123456789abcdef/", ""),
        served.request(&format!("/{token}/"), &format!("Origin: {foreign}\r\n")),
        elsewhere,
        served.upgrade("0123456789abcdef0123456789abcdef", &origin),
        served.upgrade(&token, foreign),
        served.upgrade(&token, "null"),
    ] {
        let answer = served.answer(&request);
        assert!(answer.starts_with("HTTP/1.1 403 "), "{request}{answer}");
        assert!(!answer.contains(&token), "a refusal tells the token: {answer}");
    }
    let answer = served.answer(&served.request(&format!("/{token}/"), ""));
    assert!(answer.starts_with("HTTP/1.1 200 OK\r\n") && answer.contains("class=\"live\""), "{}", &answer[..200]);
    let policy = answer.lines().find(|line| line.starts_with("Content-Security-Policy: default-src 'none'")).unwrap();
    assert!(policy.contains(&format!("connect-src ws://127.0.0.1:{}", served.port)), "{policy}");
    drop(served.page());
    assert_eq!(served.ended(), Ended::Left);
}

/// The port is open only on the loopback address; connections to other addresses of this computer are rejected.
#[test]
fn other_addresses_of_this_computer_are_closed() {
    let served = Served::new(TIMEOUT);
    assert!(served.connected().peer_addr().unwrap().ip().is_loopback());
    // the address from which packets would leave this computer; nothing is sent
    let outside = std::net::UdpSocket::bind("0.0.0.0:0")
        .and_then(|socket| socket.connect("192.0.2.1:9").and_then(|()| socket.local_addr()))
        .map(|address| address.ip());
    let mut others: Vec<std::net::IpAddr> = outside.into_iter().filter(|address| !address.is_loopback()).collect();
    if cfg!(target_os = "linux") {
        others.push([127, 0, 0, 2].into());
    }
    for address in others {
        let tried = TcpStream::connect_timeout(&(address, served.port).into(), TIMEOUT);
        assert!(tried.is_err(), "{address} is served");
    }
}

/// A text that is not a command is answered with an error, and the connection stays open; a text that is too long closes it, and the server
/// continues.
#[test]
fn malformed_messages_are_refused() {
    let served = Served::new(TIMEOUT);
    let mut page = served.page();
    assert_eq!(told(&mut page, "connected")["events"], serde_json::json!([]));
    for bad in [
        Message::text("fly"),
        Message::text("{\"do\":\"run\",\"and\":1}"),
        Message::text("[".repeat(10_000)),
        Message::text(r#"{"do":"set","name":"fold.motor_damping","value":-1}"#),
        Message::text(r#"{"do":"pull","station":999,"target_m":[0,0,0],"stiffness_n_m":1}"#),
        Message::binary(vec![0_u8, 159, 146, 150]),
    ] {
        page.send(bad.clone()).unwrap();
        let message = told(&mut page, "refused")["message"].to_string();
        assert!(message.len() > 20, "{bad}: {message}");
    }
    let mut long = served.page();
    let _ = long.send(Message::text("x".repeat(100_000)));
    while long.read().is_ok() {}
    // these bytes are not a WebSocket frame
    let mut torn = served.page();
    torn.get_mut().write_all(&[0xff; 64]).unwrap();
    while torn.read().is_ok() {}
    // an incomplete request does not affect other connections
    let mut half = served.connected();
    half.write_all(b"GET / HT").unwrap();
    page.send(Message::text(r#"{"do":"step"}"#)).unwrap();
    assert_eq!(header_of_frame(&mut page, |header| header["time"] == 5e-4)["running"], false);
}

/// The simulation runs for a page, and stops when the connection is lost without a closing message; then the server ends.
#[test]
fn a_client_that_disconnects_ends_the_work() {
    let mut served = Served::new(Duration::from_millis(200));
    let mut page = served.page();
    page.send(Message::text(r#"{"do":"watch","names":["fold.angle"]}"#)).unwrap();
    page.send(Message::text(r#"{"do":"run"}"#)).unwrap();
    let header = header_of_frame(&mut page, |header| header["time"].as_f64() > Some(0.05));
    assert_eq!((header["running"].as_bool(), &header["names"]), (Some(true), &serde_json::json!(["fold.angle"])));
    let begun = Instant::now();
    page.get_mut().shutdown(std::net::Shutdown::Both).unwrap();
    drop(page);
    assert_eq!(served.ended(), Ended::Left);
    assert!(begun.elapsed() >= Duration::from_millis(150), "a page that is loaded again has no time to come back");
}

/// A second page shows the same model, and closing it does not end the simulation for the first.
#[test]
fn pages_share_the_machine() {
    let served = Served::new(Duration::from_millis(10));
    let mut first = served.page();
    let mut second = served.page();
    told(&mut second, "connected");
    second.send(Message::text(r#"{"do":"set","name":"fold.motor_damping","value":0.5}"#)).unwrap();
    told(&mut first, "values");
    second.close(None).unwrap();
    drop(second);
    std::thread::sleep(Duration::from_millis(100));
    first.send(Message::text(r#"{"do":"step"}"#)).unwrap();
    assert_eq!(header_of_frame(&mut first, |header| header["time"] == 5e-4)["oldest"], 0.0);
}

/// Ctrl-C ends the server at once, and the page is notified.
#[test]
fn an_interruption_ends_in_order() {
    let mut served = Served::new(TIMEOUT);
    let mut page = served.page();
    told(&mut page, "connected");
    let begun = Instant::now();
    served.interrupted.store(true, Ordering::Relaxed);
    assert_eq!(served.ended(), Ended::Interrupted);
    assert!(begun.elapsed() < Duration::from_secs(5));
    let closed = loop {
        match page.read() {
            Ok(Message::Close(_)) => break true,
            Ok(_) => {}
            Err(_) => break false,
        }
    };
    assert!(closed, "the connection was torn");
}
