//! Connections of pages: a thread each, which reads orders and sends what lies in its mailbox.

use crate::live::http::{Admission, Door, answer, read_head, switching};
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

/// Largest number of connections at once, pages and requests.
const MOST_CONNECTIONS: usize = 32;

/// Largest message of a page in bytes: orders are short.
const LARGEST_ORDER: usize = 64 << 10;

/// Largest number of messages that wait for a page. A page that cannot keep up misses the oldest pictures.
const MOST_WAITING: usize = 60;

/// Time in which a request has to arrive.
const PATIENCE: Duration = Duration::from_secs(5);

/// Time between two looks into the mailbox.
const LOOK: Duration = Duration::from_millis(5);

/// What a connection tells the simulation.
pub(super) enum News {
    /// A page was sent; it will come.
    Coming,
    /// A page has come.
    Joined(u64),
    /// It asks for something.
    Asked(u64, Order),
    /// It has gone.
    Left,
}

/// Messages for one page.
#[derive(Default)]
struct Mailbox {
    waiting: Mutex<VecDeque<Message>>,
}

impl Mailbox {
    fn put(&self, message: Message) {
        let mut waiting = locked(&self.waiting);
        if waiting.len() >= MOST_WAITING {
            // texts are few, and each counts
            let oldest = waiting.iter().position(|message| message.is_binary()).unwrap_or(0);
            waiting.remove(oldest);
        }
        waiting.push_back(message);
    }
}

/// A panic elsewhere does not spoil what the lock guards: lists that are whole at any time.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// All connections of a server.
pub(super) struct Clients {
    door: Door,
    page: String,
    news: Mutex<Sender<News>>,
    mailboxes: Mutex<Vec<(u64, Arc<Mailbox>)>>,
    connections: AtomicUsize,
    next: AtomicUsize,
    ended: AtomicBool,
}

impl Clients {
    /// No connections yet.
    pub fn new(door: Door, page: String, news: Sender<News>) -> Self {
        Self {
            door,
            page,
            news: Mutex::new(news),
            mailboxes: Mutex::default(),
            connections: AtomicUsize::new(0),
            next: AtomicUsize::new(0),
            ended: AtomicBool::new(false),
        }
    }

    /// Ends all connections; their threads notice within [`LOOK`].
    pub fn end(&self) {
        self.ended.store(true, Ordering::Release);
    }

    /// Number of connections.
    pub fn connections(&self) -> usize {
        self.connections.load(Ordering::Acquire)
    }

    /// Sends a picture to all pages.
    pub fn show(&self, picture: Vec<u8>) {
        let picture = Bytes::from(picture);
        locked(&self.mailboxes).iter().for_each(|(_, mailbox)| mailbox.put(Message::Binary(picture.clone())));
    }

    /// Sends a text to all pages, or to one.
    pub fn tell(&self, text: &str, to: Option<u64>) {
        let wanted = |id: u64| to.is_none_or(|to| to == id);
        let boxes = locked(&self.mailboxes);
        boxes.iter().filter(|(id, _)| wanted(*id)).for_each(|(_, mailbox)| mailbox.put(Message::text(text)));
    }

    /// Serves a connection in a thread of its own.
    pub fn attend(self: &Arc<Self>, stream: TcpStream) {
        let clients = Arc::clone(self);
        let serve = move || {
            let among = clients.connections.fetch_add(1, Ordering::AcqRel);
            // a connection that fails concerns nobody but its page
            let _ = clients.serve(stream, among < MOST_CONNECTIONS);
            clients.connections.fetch_sub(1, Ordering::AcqRel);
        };
        let _ = std::thread::Builder::new().name("connection".to_owned()).spawn(serve);
    }

    fn serve(&self, mut stream: TcpStream, has_room: bool) -> io::Result<()> {
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let is_near = stream.peer_addr().is_ok_and(|peer| peer.ip().is_loopback());
        let refused = |status, reason: &str| answer(status, "text/plain", &format!("{reason}\n"), &self.door);
        if !is_near {
            return stream.write_all(&refused(403, "this server answers programs of its own computer only"));
        }
        if !has_room {
            return stream.write_all(&refused(503, "too many connections; close some of the pages"));
        }
        let (head, rest) = read_head(&stream)?;
        match self.door.admit(&head) {
            Admission::Page => {
                self.report(News::Coming);
                stream.write_all(&answer(200, "text/html", &self.page, &self.door))?;
            }
            Admission::Refused(status, reason) => stream.write_all(&refused(status, &reason))?,
            Admission::Socket(accept) => {
                stream.write_all(&switching(&accept))?;
                return self.converse(stream, rest);
            }
        }
        stream.shutdown(Shutdown::Write)
    }

    /// Orders in, pictures out, until one side ends it.
    fn converse(&self, stream: TcpStream, read_already: Vec<u8>) -> io::Result<()> {
        stream.set_read_timeout(Some(LOOK))?;
        let limits = WebSocketConfig::default()
            .max_message_size(Some(LARGEST_ORDER))
            .max_frame_size(Some(LARGEST_ORDER))
            .read_buffer_size(LARGEST_ORDER);
        let mut socket = WebSocket::from_partially_read(stream, read_already, Role::Server, Some(limits));
        let id = self.next.fetch_add(1, Ordering::Relaxed) as u64;
        let mailbox = Arc::new(Mailbox::default());
        locked(&self.mailboxes).push((id, Arc::clone(&mailbox)));
        self.report(News::Joined(id));
        while self.turn(&mut socket, id, &mailbox) {}
        locked(&self.mailboxes).retain(|(other, _)| *other != id);
        self.report(News::Left);
        Ok(())
    }

    /// Sends what waits and reads what came; false when the connection has ended.
    fn turn(&self, socket: &mut WebSocket<TcpStream>, id: u64, mailbox: &Mailbox) -> bool {
        let waiting = std::mem::take(&mut *locked(&mailbox.waiting));
        let sent = waiting.into_iter().try_for_each(|message| socket.send(message));
        if self.ended.load(Ordering::Acquire) {
            // the page says that the simulation has ended, whatever it still hears
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
            Message::Binary(_) => Err("a message is not an order: orders are texts".to_owned()),
            Message::Ping(_) | Message::Pong(_) | Message::Frame(_) => return true,
            // the next read answers it and ends the connection
            Message::Close(_) => return true,
        };
        match order {
            Ok(order) => self.report(News::Asked(id, order)),
            Err(reason) => mailbox.put(Message::text(refusal(&reason))),
        }
        true
    }

    fn report(&self, news: News) {
        // the simulation has ended when nobody listens
        let _ = locked(&self.news).send(news);
    }
}

/// The message that an order is refused.
pub(super) fn refusal(reason: &str) -> String {
    serde_json::json!({ "kind": "refused", "message": reason }).to_string()
}
