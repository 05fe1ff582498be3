//! HTTP requests and their access control: the server offers only the page and its WebSocket, both protected by a token.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha1::{Digest, Sha1};
use std::io::{self, Read};

/// Maximum size of the head of a request in bytes.
const LARGEST_HEAD: usize = 16 << 10;

/// Maximum number of headers.
const MOST_HEADERS: usize = 64;

/// Suffix of the key in a WebSocket handshake, RFC 6455 section 1.3.
const GUID: &str = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";

/// Address of the server.
#[derive(Debug, Clone)]
pub(super) struct ServerAddress {
    /// Port on the loopback interface.
    pub port: u16,
    /// Random first component of every path.
    pub token: String,
}

/// Answer to a request.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Access {
    /// The page.
    Page,
    /// The page's WebSocket; the string is the `Sec-WebSocket-Accept` value for its key.
    Socket(String),
    /// An error, with HTTP status and reason.
    Refused(u16, String),
}

impl ServerAddress {
    /// Creates an address with a new token of 128 random bits.
    pub fn new(port: u16) -> io::Result<Self> {
        let mut bytes = [0_u8; 16];
        getrandom::fill(&mut bytes).map_err(|error| io::Error::other(error.to_string()))?;
        Ok(Self { port, token: bytes.iter().map(|byte| format!("{byte:02x}")).collect() })
    }

    /// `127.0.0.1:PORT`.
    pub fn host(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    /// The only origin from which requests are accepted.
    pub fn origin(&self) -> String {
        format!("http://{}", self.host())
    }

    /// Address of the page.
    pub fn page_url(&self) -> String {
        format!("{}/{}/", self.origin(), self.token)
    }

    /// Decides on access from the head of a request.
    pub fn check(&self, head: &[u8]) -> Access {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        let whole = request.parse(head).is_ok_and(|status| status.is_complete());
        let (Some(method), Some(path), true) = (request.method, request.path, whole) else {
            return Access::Refused(400, "this is not an HTTP/1.1 request".to_owned());
        };
        let values = |name: &str| {
            let same = request.headers.iter().filter(|header| header.name.eq_ignore_ascii_case(name));
            same.map(|header| String::from_utf8_lossy(header.value).trim().to_owned()).collect::<Vec<_>>()
        };
        // protects against DNS rebinding
        let (hosts, own) = (values("host"), self.host());
        if hosts != [own.as_str()] {
            return Access::Refused(
                403,
                format!(
                    "this server answers only to the host name {own}; open the address \
                                                 that it printed"
                ),
            );
        }
        let (origins, own) = (values("origin"), self.origin());
        if let Some(other) = origins.iter().find(|origin| **origin != own) {
            let other: String = other.chars().take(80).collect();
            return Access::Refused(403, format!("requests must come from {own}, not from {other}"));
        }
        let (given, rest) = path.strip_prefix('/').and_then(|path| path.split_once('/')).unwrap_or((path, ""));
        if !same(given.as_bytes(), self.token.as_bytes()) {
            return Access::Refused(
                403,
                "the address lacks the token; open the address that foldwing live printed".to_owned(),
            );
        }
        if method != "GET" {
            return Access::Refused(405, format!("{method} is not supported; use GET"));
        }
        match rest {
            "" => Access::Page,
            "socket" if origins.is_empty() => Access::Refused(
                403,
                format!("the WebSocket is only for the page of {own}, and this request has no origin"),
            ),
            "socket" => {
                let names = |name: &str, wanted: &str| {
                    values(name)
                        .iter()
                        .flat_map(|value| value.split(','))
                        .any(|part| part.trim().eq_ignore_ascii_case(wanted))
                };
                let upgrades = names("upgrade", "websocket") && names("connection", "upgrade");
                match values("sec-websocket-key").as_slice() {
                    [key] if upgrades && names("sec-websocket-version", "13") => Access::Socket(accepted(key)),
                    _ => {
                        Access::Refused(426, "this address accepts only WebSocket connections of version 13".to_owned())
                    }
                }
            }
            _ => Access::Refused(404, "this server has only the page and its WebSocket".to_owned()),
        }
    }
}

/// `Sec-WebSocket-Accept` value for a key, RFC 6455 section 4.2.2.
fn accepted(key: &str) -> String {
    STANDARD.encode(Sha1::digest(format!("{key}{GUID}").as_bytes()))
}

/// Compares in constant time.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |differ, (a, b)| differ | (a ^ b)) == 0
}

/// Reads the head of a request, and the bytes received after it.
pub(super) fn read_head(mut stream: impl Read) -> io::Result<(Vec<u8>, Vec<u8>)> {
    let (mut bytes, mut part) = (Vec::new(), [0_u8; 2048]);
    loop {
        let count = stream.read(&mut part)?;
        if count == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let from = bytes.len().saturating_sub(3);
        bytes.extend_from_slice(&part[..count]);
        if let Some(at) = bytes[from..].windows(4).position(|four| four == b"\r\n\r\n") {
            let rest = bytes.split_off(from + at + 4);
            return Ok((bytes, rest));
        }
        if bytes.len() > LARGEST_HEAD {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "the header of the request is too long"));
        }
    }
}

/// Headers of every response: no caching, no referrer, no embedding by other pages.
const SAFETY: &str = "Cache-Control: no-store\r\nReferrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\n\
    X-Frame-Options: SAMEORIGIN\r\nCross-Origin-Resource-Policy: same-origin\r\nConnection: close\r\n";

/// Response with a text.
pub(super) fn answer(status: u16, kind: &str, text: &str, address: &ServerAddress) -> Vec<u8> {
    let reason = match status {
        200 => "OK",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        426 => "Upgrade Required",
        _ => "Service Unavailable",
    };
    let policy = format!(
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; media-src blob:; \
         connect-src ws://{}; base-uri 'none'; form-action 'none'",
        address.host()
    );
    format!(
        "HTTP/1.1 {status} {reason}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {}\r\n{SAFETY}\
         Content-Security-Policy: {policy}\r\n\r\n{text}",
        text.len()
    )
    .into_bytes()
}

/// Response that opens a WebSocket.
pub(super) fn switching(accept: &str) -> Vec<u8> {
    format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: {accept}\r\n\r\n"
    )
    .into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address() -> ServerAddress {
        ServerAddress { port: 4000, token: "a1b2".to_owned() }
    }

    fn asked(path: &str, headers: &[&str]) -> Access {
        let lines: String = headers.iter().map(|line| format!("{line}\r\n")).collect();
        address().check(format!("GET {path} HTTP/1.1\r\n{lines}\r\n").as_bytes())
    }

    /// All 128 bits are random: the first and the second half of four tokens differ from each other.
    #[test]
    fn tokens_are_random_in_both_halves() {
        let tokens: Vec<String> = (0..4).map(|_| ServerAddress::new(4000).unwrap().token).collect();
        let mut halves: Vec<&str> = tokens.iter().flat_map(|token| [&token[..16], &token[16..]]).collect();
        assert!(halves.iter().all(|half| half.len() == 16), "{tokens:?}");
        halves.sort_unstable();
        halves.dedup();
        assert_eq!(halves.len(), 8, "{tokens:?}");
    }

    const HOST: &str = "Host: 127.0.0.1:4000";
    const ORIGIN: &str = "Origin: http://127.0.0.1:4000";
    const UPGRADE: [&str; 4] = [
        "Connection: keep-alive, Upgrade",
        "Upgrade: websocket",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
    ];

    /// The page is served to requests with the token, and the WebSocket only to this page. The key is the example of RFC
    /// 6455, section 1.3.
    #[test]
    fn the_page_and_its_socket_exist() {
        assert_eq!(asked("/a1b2/", &[HOST]), Access::Page);
        let socket = [&[HOST, ORIGIN][..], &UPGRADE].concat();
        assert_eq!(asked("/a1b2/socket", &socket), Access::Socket("s3pPLMBiTxaQ9kYGzzhZRbK+xOo=".to_owned()));
    }

    #[test]
    fn others_are_refused() {
        let with = |more: &[&'static str]| [more, &UPGRADE].concat();
        for (path, headers, status) in [
            ("/", vec![HOST], 403),
            ("/a1b3/", vec![HOST], 403),
            ("/a1b/", vec![HOST], 403),
            ("/a1b2", vec![HOST], 403),
            ("/a1b22/", vec![HOST], 403),
            ("//a1b2/", vec![HOST], 403),
            ("/a1b2/other", vec![HOST], 404),
            ("/a1b2/", vec![], 403),
            ("/a1b2/", vec!["Host: evil.example:4000"], 403),
            ("/a1b2/", vec!["Host: localhost:4000"], 403),
            ("/a1b2/", vec!["Host: 127.0.0.1:4001"], 403),
            ("/a1b2/", vec![HOST, "Host: evil.example"], 403),
            ("/a1b2/", vec![HOST, "Origin: http://evil.example"], 403),
            ("/a1b2/", vec![HOST, "Origin: null"], 403),
            ("/a1b2/socket", with(&[HOST]), 403),
            ("/a1b2/socket", with(&[HOST, "Origin: http://evil.example"]), 403),
            ("/a1b2/socket", with(&[HOST, "Origin: https://127.0.0.1:4000"]), 403),
            ("/a1b2/socket", with(&[HOST, ORIGIN, "Origin: http://evil.example"]), 403),
            ("/wrong/socket", with(&[HOST, ORIGIN]), 403),
            ("/a1b2/socket", vec![HOST, ORIGIN], 426),
            ("/a1b2/socket", vec![HOST, ORIGIN, UPGRADE[0], UPGRADE[1], UPGRADE[3]], 426),
        ] {
            let Access::Refused(found, reason) = asked(path, &headers) else { panic!("{path} {headers:?}") };
            assert_eq!(found, status, "{path} {headers:?}: {reason}");
        }
        assert!(matches!(
            address().check(b"POST /a1b2/ HTTP/1.1\r\nHost: 127.0.0.1:4000\r\n\r\n"),
            Access::Refused(405, _)
        ));
        assert!(matches!(address().check(b"\x16\x03\x01\r\n\r\n"), Access::Refused(400, _)));
        assert!(matches!(address().check(b""), Access::Refused(400, _)));
    }

    /// Heads are read up to the empty line, however the stream is divided into parts, and their size is limited.
    #[test]
    fn heads_are_read_in_pieces() {
        struct Bytes(Vec<u8>, usize);
        impl Read for Bytes {
            fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
                let count = self.1.min(into.len()).min(self.0.len());
                into[..count].copy_from_slice(&self.0[..count]);
                self.0.drain(..count);
                Ok(count)
            }
        }
        for piece in 1..9 {
            let (head, rest) = read_head(Bytes(b"GET /\r\nA: b\r\n\r\n".to_vec(), piece)).unwrap();
            assert_eq!((head.as_slice(), rest.len()), (&b"GET /\r\nA: b\r\n\r\n"[..], 0));
        }
        let (_, rest) = read_head(Bytes(b"GET /\r\n\r\nmore".to_vec(), 64)).unwrap();
        assert_eq!(rest, b"more");
        assert!(read_head(Bytes(vec![b'a'; 100_000], 512)).is_err());
        assert!(read_head(Bytes(b"GET".to_vec(), 64)).is_err());
    }

    /// Tokens have 128 bits and differ from each other.
    #[test]
    fn tokens_are_random() {
        let [a, b] = [(); 2].map(|()| ServerAddress::new(1).unwrap().token);
        assert!(a != b && a.len() == 32 && a.bytes().all(|byte| byte.is_ascii_hexdigit()), "{a} {b}");
    }
}
