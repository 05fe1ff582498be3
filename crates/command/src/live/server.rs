//! The server: a listener on the loopback interface, and the loop that joins pages and simulation.

use crate::live::clients::{Clients, News, refusal};
use crate::live::http::Door;
use crate::live::session::{PICTURES_1_S, Session};
use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, channel};
use std::time::{Duration, Instant};

/// Time after which the server ends when the last page has gone.
const GRACE: Duration = Duration::from_secs(3);

/// The same when a page was sent meanwhile: a browser may take long to show it.
const GRACE_FOR_LOADING: Duration = Duration::from_secs(30);

/// Longest time without a look at interruptions.
const LOOK: Duration = Duration::from_millis(50);

/// Time in which connections have to end at last.
const FAREWELL: Duration = Duration::from_millis(500);

/// Why a live simulation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The last page has gone.
    Left,
    /// A signal, as of Ctrl-C.
    Interrupted,
}

/// A server that has its address.
pub struct Server {
    listener: TcpListener,
    door: Door,
    /// Time after which it ends when the last page has gone.
    grace: Duration,
}

impl Server {
    /// Takes a port of the loopback interface, any free one for 0.
    ///
    /// # Errors
    /// The port is taken or not allowed.
    pub fn bind(port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let door = Door::new(listener.local_addr()?.port())?;
        Ok(Self { listener, door, grace: GRACE })
    }

    /// Address of the page, with the token.
    pub fn address(&self) -> String {
        self.door.address()
    }

    /// The same server with another time after the last page.
    #[cfg(test)]
    pub(super) fn with_grace(self, grace: Duration) -> Self {
        Self { grace, ..self }
    }

    /// Port.
    pub fn port(&self) -> u16 {
        self.door.port
    }

    /// Shows a simulation until the last page has gone or `interrupted` is set. Time stands until a page lets it run, and while there is
    /// none.
    ///
    /// # Errors
    /// The listener fails.
    pub fn run(self, session: &mut Session, interrupted: &AtomicBool) -> io::Result<Ended> {
        let (sender, news) = channel();
        let clients = Arc::new(Clients::new(self.door, session.page(), sender));
        let (listener, ended) = (self.listener, Arc::new(AtomicBool::new(false)));
        let (own, own_ended) = (Arc::clone(&clients), Arc::clone(&ended));
        let address = listener.local_addr()?;
        let accept = move || {
            for stream in listener.incoming() {
                if own_ended.load(Ordering::Acquire) {
                    break;
                }
                match stream {
                    Ok(stream) => own.attend(stream),
                    // out of descriptors: others end soon
                    Err(_) => std::thread::sleep(LOOK),
                }
            }
        };
        let acceptor = std::thread::Builder::new().name("listener".to_owned()).spawn(accept)?;
        let audience = Audience { grace: self.grace, pages: 0, ends: None, loads_until: None };
        let why = hold(session, &clients, (&news, interrupted), audience);
        ended.store(true, Ordering::Release);
        clients.end();
        // the listener waits for one more connection, and then sees that it has ended
        drop(std::net::TcpStream::connect(address));
        let _ = acceptor.join();
        let begun = Instant::now();
        while clients.connections() > 0 && begun.elapsed() < FAREWELL {
            std::thread::sleep(Duration::from_millis(5));
        }
        Ok(why)
    }
}

/// The loop of the simulation.
fn hold(
    session: &mut Session,
    clients: &Clients,
    (news, interrupted): (&Receiver<News>, &AtomicBool),
    mut audience: Audience,
) -> Ended {
    let between = Duration::from_secs_f64(1.0 / PICTURES_1_S);
    let mut next_picture = Instant::now();
    loop {
        loop {
            match news.try_recv() {
                Ok(one) => hear(session, clients, one, &mut audience),
                Err(TryRecvError::Empty | TryRecvError::Disconnected) => break,
            }
        }
        if interrupted.load(Ordering::Relaxed) {
            return Ended::Interrupted;
        }
        if audience.pages == 0 {
            session.pause();
            if audience.ends.is_some_and(|end| Instant::now() >= end) {
                return Ended::Left;
            }
        }
        session.advance();
        let now = Instant::now();
        if now >= next_picture && audience.pages > 0 {
            if let Some(picture) = session.picture() {
                clients.show(picture);
            }
            // after a pause the schedule begins anew
            next_picture = (next_picture + between).max(now);
        }
        let picture = if audience.pages > 0 { next_picture.saturating_duration_since(Instant::now()) } else { LOOK };
        let wait = session.until_step().map_or(picture, |step| step.min(picture)).min(LOOK);
        if wait.is_zero() {
            continue;
        }
        match news.recv_timeout(wait) {
            Ok(one) => hear(session, clients, one, &mut audience),
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
        }
    }
}

/// The pages that look.
struct Audience {
    /// Time after which the server ends when the last of them has gone.
    grace: Duration,
    /// Number of connected pages.
    pages: usize,
    /// When to end if no page comes back; `None` before the first page has gone.
    ends: Option<Instant>,
    /// Until when a page that was sent may still come.
    loads_until: Option<Instant>,
}

/// Takes one message of a page to the simulation.
fn hear(session: &mut Session, clients: &Clients, news: News, audience: &mut Audience) {
    match news {
        News::Coming => {
            let until = Instant::now() + GRACE_FOR_LOADING;
            audience.loads_until = Some(until);
            // before the first page has gone nothing ends
            audience.ends = audience.ends.map(|end| end.max(until));
        }
        News::Joined(id) => {
            audience.pages += 1;
            (audience.ends, audience.loads_until) = (None, None);
            let welcome = session.welcome();
            clients.tell(&welcome, Some(id));
        }
        News::Left => {
            audience.pages = audience.pages.saturating_sub(1);
            // a browser asks for a page anew before it lets the old one go
            let end = Instant::now() + audience.grace;
            audience.ends = Some(audience.loads_until.map_or(end, |until| until.max(end)));
            // nobody holds the spring any more
            session.let_go();
        }
        News::Asked(id, order) => match session.obey(&order) {
            Ok(Some(message)) => clients.tell(&message, None),
            Ok(None) => {}
            Err(reason) => clients.tell(&refusal(&reason), Some(id)),
        },
    }
}
