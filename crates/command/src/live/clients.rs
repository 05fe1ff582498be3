//! Connections of pages: each has a thread that reads commands and sends the messages of its mailbox.

use crate::live::http::{Access, ServerAddress, answer, read_head, switching};
use crate::live::order::Order;
use std::collections::VecDeque;
use std::io::{self, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Bytes, Error, Message, WebSocket};

/// Maximum number of simultaneous connections, pages and requests.
const MOST_CONNECTIONS: usize = 32;

/// Maximum size of a message from a page in bytes; commands are short.
const LARGEST_ORDER: usize = 64 << 10;

/// Maximum number of messages queued for a page. A page that cannot keep up misses the oldest frames.
const MOST_WAITING: usize = 60;

/// Timeout for reading requests and for writing.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Interval at which the mailbox is polled.
const POLL: Duration = Duration::from_millis(5);

/// Event of a connection, passed to the simulation.
pub(super) enum ClientEvent {
    /// The page was sent; its WebSocket connection follows.
    Requested,
    /// The WebSocket of a page was opened.
    Connected(u64),
    /// A command of a page.
    Ordered(u64, Order),
    /// The WebSocket of a page was closed.
    Disconnected,
}

/// Queue of messages for one page.
#[derive(Default)]
struct Mailbox {
    waiting: Mutex<VecDeque<Message>>,
}

impl Mailbox {
    fn put(&self, message: Message) {
        let mut waiting = locked(&self.waiting);
        if waiting.len() >= MOST_WAITING {
            // drop frames, since texts are few and none may be lost
            let oldest = waiting.iter().position(|message| message.is_binary()).unwrap_or(0);
            waiting.remove(oldest);
        }
        waiting.push_back(message);
    }
}

/// Locks a mutex, ignoring poisoning: the guarded lists are always consistent.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// All connections of a server.
pub(super) struct Clients {
    address: ServerAddress,
    page: String,
    events: Mutex<Sender<ClientEvent>>,
    mailboxes: Mutex<Vec<(u64, Arc<Mailbox>)>>,
    connections: AtomicUsize,
    next: AtomicUsize,
    ended: AtomicBool,
}

impl Clients {
    /// Creates the list, without connections.
    pub fn new(address: ServerAddress, page: String, events: Sender<ClientEvent>) -> Self {
        Self {
            address,
            page,
            events: Mutex::new(events),
            mailboxes: Mutex::default(),
            connections: AtomicUsize::new(0),
            next: AtomicUsize::new(0),
            ended: AtomicBool::new(false),
        }
    }

    /// Ends all connections; their threads react within [`POLL`].
    pub fn end(&self) {
        self.ended.store(true, Ordering::Release);
    }

    /// Number of connections.
    pub fn connections(&self) -> usize {
        self.connections.load(Ordering::Acquire)
    }

    /// Sends a frame to all pages.
    pub fn send_frame(&self, frame: Vec<u8>) {
        let frame = Bytes::from(frame);
        locked(&self.mailboxes).iter().for_each(|(_, mailbox)| mailbox.put(Message::Binary(frame.clone())));
    }

    /// Sends a text to all pages, or to the page given by `to`.
    pub fn send_text(&self, text: &str, to: Option<u64>) {
        let wanted = |id: u64| to.is_none_or(|to| to == id);
        let boxes = locked(&self.mailboxes);
        boxes.iter().filter(|(id, _)| wanted(*id)).for_each(|(_, mailbox)| mailbox.put(Message::text(text)));
    }

    /// Serves a connection in a new thread.
    pub fn serve_in_thread(self: &Arc<Self>, stream: TcpStream) {
        let clients = Arc::clone(self);
        let serve = move || {
            let among = clients.connections.fetch_add(1, Ordering::AcqRel);
            // an error affects this connection only
            let _ = clients.serve(stream, among < MOST_CONNECTIONS);
            clients.connections.fetch_sub(1, Ordering::AcqRel);
        };
        let _ = std::thread::Builder::new().name("connection".to_owned()).spawn(serve);
    }

    fn serve(&self, mut stream: TcpStream, has_room: bool) -> io::Result<()> {
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(TIMEOUT))?;
        stream.set_write_timeout(Some(TIMEOUT))?;
        let is_near = stream.peer_addr().is_ok_and(|peer| peer.ip().is_loopback());
        let refused = |status, reason: &str| answer(status, "text/plain", &format!("{reason}\n"), &self.address);
        if !is_near {
            return stream.write_all(&refused(403, "this server accepts connections only from its own computer"));
        }
        if !has_room {
            return stream.write_all(&refused(503, "too many connections; close some of the pages"));
        }
        let (head, rest) = read_head(&stream)?;
        match self.address.check(&head) {
            Access::Page => {
                self.report(ClientEvent::Requested);
                stream.write_all(&answer(200, "text/html", &self.page, &self.address))?;
            }
            Access::Refused(status, reason) => stream.write_all(&refused(status, &reason))?,
            Access::Socket(accept) => {
                stream.write_all(&switching(&accept))?;
                return self.exchange(stream, rest);
            }
        }
        stream.shutdown(Shutdown::Write)
    }

    /// Receives commands and sends frames until one side closes the connection.
    fn exchange(&self, stream: TcpStream, read_already: Vec<u8>) -> io::Result<()> {
        stream.set_read_timeout(Some(POLL))?;
        let limits = WebSocketConfig::default()
            .max_message_size(Some(LARGEST_ORDER))
            .max_frame_size(Some(LARGEST_ORDER))
            .read_buffer_size(LARGEST_ORDER);
        let mut socket = WebSocket::from_partially_read(stream, read_already, Role::Server, Some(limits));
        let id = self.next.fetch_add(1, Ordering::Relaxed) as u64;
        let mailbox = Arc::new(Mailbox::default());
        locked(&self.mailboxes).push((id, Arc::clone(&mailbox)));
        self.report(ClientEvent::Connected(id));
        while self.turn(&mut socket, id, &mailbox) {}
        locked(&self.mailboxes).retain(|(other, _)| *other != id);
        self.report(ClientEvent::Disconnected);
        Ok(())
    }

    /// Sends the queued messages and reads one; returns false when the connection has ended.
    fn turn(&self, socket: &mut WebSocket<TcpStream>, id: u64, mailbox: &Mailbox) -> bool {
        let waiting = std::mem::take(&mut *locked(&mailbox.waiting));
        let sent = waiting.into_iter().try_for_each(|message| socket.send(message));
        if self.ended.load(Ordering::Acquire) {
            // an error has no consequence because the process ends
            let _ = socket.close(None).and_then(|()| socket.flush());
            return false;
        }
        let message = match sent.and_then(|()| socket.read()) {
            Ok(message) => message,
            Err(Error::Io(error)) => {
                return matches!(
                    error.kind(),
                    io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted
                );
            }
            Err(_) => return false,
        };
        let order = match &message {
            Message::Text(text) => Order::read(text),
            Message::Binary(_) => Err("a message is not a command: commands are sent as text".to_owned()),
            Message::Ping(_) | Message::Pong(_) | Message::Frame(_) => return true,
            // the next read answers the request to close and ends the connection
            Message::Close(_) => return true,
        };
        match order {
            Ok(order) => self.report(ClientEvent::Ordered(id, order)),
            Err(reason) => mailbox.put(Message::text(refusal(&reason))),
        }
        true
    }

    fn report(&self, events: ClientEvent) {
        // after the end of the simulation there is no receiver
        let _ = locked(&self.events).send(events);
    }
}

/// Message to a page that a command is invalid.
pub(super) fn refusal(reason: &str) -> String {
    serde_json::json!({ "kind": "refused", "message": reason }).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refusals_are_json_whatever_the_reason_quotes() {
        let reason = "no output \"tip\\y\"\nis known";
        let read: serde_json::Value = serde_json::from_str(&refusal(reason)).unwrap();
        assert_eq!(read, serde_json::json!({ "kind": "refused", "message": reason }));
    }
}
