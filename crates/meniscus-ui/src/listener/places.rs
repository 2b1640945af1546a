//! Places for connections, shared out among addresses so that one peer cannot keep others out.
//!
//! ```text
//! a newcomer finds ...                            then
//!   its address at its share of connections       the oldest of its address's silent or asking ones goes,
//!                                                 whichever are more
//!   all places taken                              the same of the fullest address,
//!                                                 or its newest guest, if the newcomer's address has fewer
//! ```
//! A connection is silent until its request has come, then asking, and a guest if it stays: a viewer. Whoever only opens
//! connections therefore ends no answer while fewer than half of an address's other connections ask. An IPv6 peer has a whole
//! /64 at its disposal, so that counts as one address.

use super::TimedStream;
use super::connection::{Entry, Stage, counted, peeks_request};
use std::net::{IpAddr, Shutdown, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Limits on connections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Limits {
    /// Connections in all, guests included.
    pub(crate) connections: usize,
    /// Connections of one address.
    pub(crate) connections_each: usize,
    /// Guests in all.
    pub(crate) guests: usize,
    /// Guests of one address; fewer than its connections.
    pub(crate) guests_each: usize,
}

/// Entries in the order of their arrival, and the next one's number.
#[derive(Debug, Default)]
struct Held {
    entries: Vec<Entry>,
    next: u64,
}

/// The places of a server.
#[derive(Debug)]
pub(crate) struct Places {
    limits: Limits,
    held: Mutex<Held>,
}

/// One place; dropping it frees it.
#[derive(Debug)]
pub(crate) struct Place {
    places: Arc<Places>,
    number: u64,
}

impl Places {
    /// Returns places within `limits`, all free.
    pub(crate) fn new(limits: Limits) -> Arc<Self> {
        Arc::new(Self { limits, held: Mutex::default() })
    }

    /// Gives the peer of `stream` a place; `None` where every place is taken by guests of no larger share.
    pub(crate) fn enter(self: &Arc<Self>, stream: &Arc<TcpStream>) -> Option<Place> {
        let address = counted(stream.peer_addr().ok()?.ip());
        let mut held = self.held();
        if held.count(address) >= self.limits.connections_each {
            held.send_away_of(address)?;
        }
        if held.entries.len() >= self.limits.connections {
            held.make_room(address)?;
        }
        let number = held.next;
        held.next += 1;
        held.entries.push(Entry { number, address, stage: Stage::Silent, stream: Arc::clone(stream) });
        Some(Place { places: Arc::clone(self), number })
    }

    /// Number of connections.
    pub(crate) fn taken(&self) -> usize {
        self.held().entries.len()
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Place {
    /// Waits for the first bytes of `stream`, the connection of this place, and notes a whole request before it is read.
    ///
    /// Read bytes are seen only by the thread that read them, and under load it may not run again for long.
    pub(crate) fn await_request(&self, stream: &TimedStream) {
        // An error comes again where the stream is read.
        if peeks_request(|head| stream.peek(head)) {
            self.ask();
        }
    }

    /// Notes that the connection's request has come: while those without one are more, they make room before it.
    pub(crate) fn ask(&self) {
        let mut held = self.places.held();
        // One that was sent away meanwhile has no entry, and its stream says so.
        if let Some(own) = held.entries.iter_mut().find(|entry| entry.number == self.number) {
            own.stage = Stage::Asking;
        }
    }

    /// Makes the connection a guest, where there is room for one of its address.
    pub(crate) fn stay(&self) -> Option<()> {
        let limits = self.places.limits;
        let mut held = self.places.held();
        let address = held.entries.iter().find(|entry| entry.number == self.number)?.address;
        if held.guests(address) >= limits.guests_each {
            return None;
        }
        if held.entries.iter().filter(|entry| entry.is_guest()).count() >= limits.guests {
            let (fullest, share) = held.fullest(|held, address| held.guests(address))?;
            if share <= held.guests(address) + 1 {
                return None;
            }
            held.send_away_last(|entry| entry.address == fullest && entry.is_guest())?;
        }
        let own = held.entries.iter_mut().find(|entry| entry.number == self.number)?;
        own.stage = Stage::Guest;
        Some(())
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.places.held().entries.retain(|entry| entry.number != self.number);
    }
}

impl Held {
    fn count(&self, address: IpAddr) -> usize {
        self.entries.iter().filter(|entry| entry.address == address).count()
    }

    fn guests(&self, address: IpAddr) -> usize {
        self.entries.iter().filter(|entry| entry.address == address && entry.is_guest()).count()
    }

    /// Returns the address with the largest share, and that share.
    fn fullest(&self, share: impl Fn(&Self, IpAddr) -> usize) -> Option<(IpAddr, usize)> {
        self.entries.iter().map(|entry| (entry.address, share(self, entry.address))).max_by_key(|of| of.1)
    }

    /// Frees a place for a newcomer of `address`.
    fn make_room(&mut self, address: IpAddr) -> Option<()> {
        let (fullest, share) = self.fullest(Self::count)?;
        if let Some(()) = self.send_away_of(fullest) {
            return Some(());
        }
        let fewer = self.count(address) + 1 < share;
        let least = |entry: &Entry| if fewer { entry.address == fullest } else { !entry.is_guest() };
        self.send_away_last(least)
    }

    /// Ends a connection of `address`: the oldest of its silent or of its asking ones, whichever are more.
    ///
    /// Neither kind can take the other's half, so a newcomer has as long to be read, and then to be answered.
    fn send_away_of(&mut self, address: IpAddr) -> Option<()> {
        let number =
            |held: &Self, stage| held.entries.iter().filter(|entry| entry.is(address, stage)).count();
        let oldest = |held: &Self, stage| held.entries.iter().position(|entry| entry.is(address, stage));
        while number(self, Stage::Asking) <= number(self, Stage::Silent) {
            let place = oldest(self, Stage::Silent)?;
            let entry = self.entries.get_mut(place)?;
            if !entry.has_asked() {
                return self.end(place);
            }
            // Its thread has not run yet. Under load that takes longer than it takes dozens of others to arrive.
            entry.stage = Stage::Asking;
        }
        let place = oldest(self, Stage::Asking)?;
        self.end(place)
    }

    /// Ends the newest connection of a kind.
    fn send_away_last(&mut self, which: impl Fn(&Entry) -> bool) -> Option<()> {
        let place = self.entries.iter().rposition(which)?;
        self.end(place)
    }

    fn end(&mut self, place: usize) -> Option<()> {
        // Its thread sees the end of the stream and goes. A peer that has gone already is as good.
        let _gone = self.entries.remove(place).stream.shutdown(Shutdown::Both);
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::net::TcpListener;

    const LIMITS: Limits = Limits { connections: 6, connections_each: 4, guests: 4, guests_each: 3 };

    /// Both ends of a connection from 127.0.0.`last`.
    fn pair(listener: &TcpListener, last: u8) -> (Arc<TcpStream>, socket2::Socket) {
        let socket =
            socket2::Socket::new(socket2::Domain::IPV4, socket2::Type::STREAM, None).expect("a socket");
        let from = std::net::SocketAddr::from(([127, 0, 0, last], 0));
        socket.bind(&from.into()).expect("a loopback address");
        socket.connect(&listener.local_addr().expect("an address").into()).expect("connected");
        (Arc::new(listener.accept().expect("accepted").0), socket)
    }

    #[test]
    fn one_address_cannot_take_what_another_needs() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let places = Places::new(LIMITS);
        let enter = |last: u8| {
            let (stream, peer) = pair(&listener, last);
            places.enter(&stream).map(|place| (place, peer))
        };
        // Six connections of an address whose share is four: the oldest two have gone.
        let mut greedy: Vec<_> = (0..6).map(|_| enter(1).expect("its newest enters")).collect();
        assert_eq!(places.taken(), 4);
        assert_eq!(greedy.iter().map(|(place, _)| place.stay()).filter(Option::is_some).count(), 3);
        let second: Vec<_> = (0..3).map(|_| enter(2).expect("another address")).collect();
        assert_eq!(places.taken(), 6);
        // Three guests of one and one of the other fill the guests; a third address still gets in.
        second[2].0.stay().expect("a guest");
        let third = enter(3).expect("a new address");
        third.0.stay().expect("a new address's guest");
        assert_eq!(places.taken(), 5, "one guest of the greedy has gone");
        greedy.clear();
        drop((second, third));
        assert_eq!(places.taken(), 0);
    }

    #[test]
    fn silent_connections_push_out_none_that_is_answered() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let places = Places::new(LIMITS);
        let enter = || {
            let (stream, peer) = pair(&listener, 1);
            places.enter(&stream).map(|place| (place, peer))
        };
        let read = enter().expect("room");
        read.0.ask();
        // One whose request lies unread, as where its thread has not run yet.
        let unread = enter().expect("room");
        let mut peer = &unread.1;
        peer.write_all(b"GET / HTTP/1.1\r\n\r\n").expect("sent");
        let silent: Vec<_> = (0..20).map(|_| enter().expect("the newest enters")).collect();
        assert_eq!(read.0.stay(), Some(()), "the oldest of all is still there");
        assert_eq!(unread.0.stay(), Some(()), "it was spared as well");
        assert_eq!(places.taken(), LIMITS.connections_each);
        drop((read, unread, silent));
        // Where all ask, the oldest makes room.
        let askers: Vec<_> = (0..4).map(|_| enter().expect("room")).collect();
        askers.iter().for_each(|(place, _)| place.ask());
        let _newest = enter().expect("the newest enters");
        assert_eq!(askers.iter().position(|(place, _)| place.stay().is_some()), Some(1));
    }
}
