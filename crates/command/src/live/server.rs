//! The server: a listener on the loopback interface, and the loop that connects pages and simulation.

use crate::live::clients::{ClientEvent, Clients, refusal};
use crate::live::http::ServerAddress;
use crate::live::session::{FRAMES_1_S, Session};
use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Time between the closing of the last page and the end of the server.
const GRACE: Duration = Duration::from_secs(3);

/// Longer time if the page was requested again meanwhile, because slow browsers need time to load it.
const GRACE_FOR_LOADING: Duration = Duration::from_secs(30);

/// Maximum interval between two checks for interruption.
const POLL: Duration = Duration::from_millis(50);

/// Timeout for closing the connections at the end.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(500);

/// Reason why a live simulation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The last page was closed.
    Left,
    /// A signal, such as that of Ctrl-C, was received.
    Interrupted,
}

/// Server with its bound address.
pub struct Server {
    listener: TcpListener,
    address: ServerAddress,
    /// Time between the closing of the last page and the end of the server.
    grace: Duration,
}

impl Server {
    /// Binds a port of the loopback interface; 0 selects a free one.
    ///
    /// # Errors
    /// The port is in use or not allowed.
    pub fn bind(port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = ServerAddress::new(listener.local_addr()?.port())?;
        Ok(Self { listener, address, grace: GRACE })
    }

    /// Address of the page, with the token.
    pub fn address(&self) -> String {
        self.address.page_url()
    }

    /// Returns the server with another time between the closing of the last page and its end.
    #[cfg(test)]
    pub(super) fn with_grace(self, grace: Duration) -> Self {
        Self { grace, ..self }
    }

    /// Port.
    pub fn port(&self) -> u16 {
        self.address.port
    }

    /// Serves a simulation until the last page has been closed or `interrupted` is set. A page starts the clock, which stops while no
    /// page is connected.
    ///
    /// # Errors
    /// The listener fails.
    pub fn run(self, session: &mut Session, interrupted: &AtomicBool) -> io::Result<Ended> {
        let (sender, events) = channel();
        let clients = Arc::new(Clients::new(self.address, session.page(), sender));
        let (listener, ended) = (self.listener, Arc::new(AtomicBool::new(false)));
        let (own, own_ended) = (Arc::clone(&clients), Arc::clone(&ended));
        let address = listener.local_addr()?;
        let accept = move || {
            for stream in listener.incoming() {
                if own_ended.load(Ordering::Acquire) {
                    break;
                }
                match stream {
                    Ok(stream) => own.serve_in_thread(stream),
                    // no file descriptor is free: retry after other connections have been closed
                    Err(_) => std::thread::sleep(POLL),
                }
            }
        };
        let acceptor = std::thread::Builder::new().name("listener".to_owned()).spawn(accept)?;
        let viewers = Viewers { grace: self.grace, pages: 0, ends: None, loads_until: None };
        let why = run_loop(session, &clients, (&events, interrupted), viewers);
        ended.store(true, Ordering::Release);
        clients.end();
        // a final connection wakes the listener
        drop(std::net::TcpStream::connect(address));
        let _ = acceptor.join();
        let begun = Instant::now();
        while clients.connections() > 0 && begun.elapsed() < CLOSE_TIMEOUT {
            std::thread::sleep(Duration::from_millis(5));
        }
        Ok(why)
    }
}

/// Main loop of the simulation.
fn run_loop(
    session: &mut Session,
    clients: &Clients,
    (events, interrupted): (&Receiver<ClientEvent>, &AtomicBool),
    mut viewers: Viewers,
) -> Ended {
    let between = Duration::from_secs_f64(1.0 / FRAMES_1_S);
    let mut next_frame_at = Instant::now();
    loop {
        while let Ok(one) = events.try_recv() {
            handle(session, clients, one, &mut viewers);
        }
        if interrupted.load(Ordering::Relaxed) {
            return Ended::Interrupted;
        }
        if viewers.pages == 0 {
            session.pause();
            if viewers.ends.is_some_and(|end| Instant::now() >= end) {
                return Ended::Left;
            }
        }
        session.advance();
        let now = Instant::now();
        if now >= next_frame_at && viewers.pages > 0 {
            if let Some(frame) = session.next_frame() {
                clients.send_frame(frame);
            }
            // a late frame delays the following ones
            next_frame_at = (next_frame_at + between).max(now);
        }
        let frame = if viewers.pages > 0 { next_frame_at.saturating_duration_since(Instant::now()) } else { POLL };
        let wait = session.until_step().map_or(frame, |step| step.min(frame)).min(POLL);
        if wait.is_zero() {
            continue;
        }
        match events.recv_timeout(wait) {
            Ok(one) => handle(session, clients, one, &mut viewers),
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
        }
    }
}

/// Connected pages, and the time at which the server ends without them.
struct Viewers {
    /// Time between the closing of the last page and the end of the server.
    grace: Duration,
    /// Number of connected pages.
    pages: usize,
    /// Time at which the server ends unless a page connects before; `None` before the first page has been closed.
    ends: Option<Instant>,
    /// Latest time at which a page being loaded may connect.
    loads_until: Option<Instant>,
}

/// Passes an event of a connection to the simulation.
fn handle(session: &mut Session, clients: &Clients, events: ClientEvent, viewers: &mut Viewers) {
    match events {
        ClientEvent::Requested => {
            let until = Instant::now() + GRACE_FOR_LOADING;
            viewers.loads_until = Some(until);
            // there is no time limit for the first page
            viewers.ends = viewers.ends.map(|end| end.max(until));
        }
        ClientEvent::Connected(id) => {
            viewers.pages += 1;
            (viewers.ends, viewers.loads_until) = (None, None);
            let message = session.connected_message();
            clients.send_text(&message, Some(id));
        }
        ClientEvent::Disconnected => {
            viewers.pages = viewers.pages.saturating_sub(1);
            // when reloading, browsers request the new page before they close the old one
            let end = Instant::now() + viewers.grace;
            viewers.ends = Some(viewers.loads_until.map_or(end, |until| until.max(end)));
            // release the spring of this page, if any
            session.release_pull();
        }
        ClientEvent::Ordered(id, order) => match session.execute(&order) {
            Ok(Some(message)) => clients.send_text(&message, None),
            Ok(None) => {}
            Err(reason) => clients.send_text(&refusal(&reason), Some(id)),
        },
    }
}
