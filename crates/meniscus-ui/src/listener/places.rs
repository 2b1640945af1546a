//! Places for connections, shared out among addresses so that one peer cannot keep others out.
//!
//! ```text
//! a newcomer finds ...                            then
//!   its address at its share of connections       its address's oldest passing connection goes
//!   all places taken                              the oldest passing connection of the fullest address goes,
//!                                                 or its newest guest, if the newcomer's address holds fewer
//! ```
//! A connection is passing until it becomes a guest, one that stays: a viewer. An IPv6 peer has a whole /64 at its disposal,
//! so that counts as one address.

use std::net::{IpAddr, Ipv6Addr, Shutdown, TcpStream};
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

/// One connection.
#[derive(Debug)]
struct Entry {
    number: u64,
    address: IpAddr,
    guest: bool,
    stream: Arc<TcpStream>,
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
            held.send_away(|entry| entry.address == address && !entry.guest)?;
        }
        if held.entries.len() >= self.limits.connections {
            held.make_room(address)?;
        }
        let number = held.next;
        held.next += 1;
        held.entries.push(Entry { number, address, guest: false, stream: Arc::clone(stream) });
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
    /// Makes the connection a guest, where there is room for one of its address.
    pub(crate) fn stay(&self) -> Option<()> {
        let limits = self.places.limits;
        let mut held = self.places.held();
        let address = held.entries.iter().find(|entry| entry.number == self.number)?.address;
        if held.guests(address) >= limits.guests_each {
            return None;
        }
        if held.entries.iter().filter(|entry| entry.guest).count() >= limits.guests {
            let (fullest, share) = held.fullest(|held, address| held.guests(address))?;
            if share <= held.guests(address) + 1 {
                return None;
            }
            held.send_away_last(|entry| entry.address == fullest && entry.guest)?;
        }
        let own = held.entries.iter_mut().find(|entry| entry.number == self.number)?;
        own.guest = true;
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
        self.entries.iter().filter(|entry| entry.address == address && entry.guest).count()
    }

    /// Returns the address with the largest share, and that share.
    fn fullest(&self, share: impl Fn(&Self, IpAddr) -> usize) -> Option<(IpAddr, usize)> {
        self.entries.iter().map(|entry| (entry.address, share(self, entry.address))).max_by_key(|of| of.1)
    }

    /// Frees a place for a newcomer of `address`.
    fn make_room(&mut self, address: IpAddr) -> Option<()> {
        let (fullest, share) = self.fullest(Self::count)?;
        if let Some(()) = self.send_away(|entry| entry.address == fullest && !entry.guest) {
            return Some(());
        }
        let fewer = self.count(address) + 1 < share;
        let least = |entry: &Entry| if fewer { entry.address == fullest } else { !entry.guest };
        self.send_away_last(least)
    }

    /// Ends the oldest connection of a kind.
    fn send_away(&mut self, which: impl Fn(&Entry) -> bool) -> Option<()> {
        let place = self.entries.iter().position(which)?;
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

/// Returns the address that a peer's connections are counted under.
fn counted(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let [a, b, c, d, ..] = address.segments();
            Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0).into()
        }
        v4 @ IpAddr::V4(_) => v4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
    fn a_network_of_ipv6_counts_as_one_address() {
        let of = |text: &str| counted(text.parse().expect("an address"));
        assert_eq!(of("2001:db8::1"), of("2001:db8::ffff:2"));
        assert_ne!(of("2001:db8::1"), of("2001:db8:0:1::1"));
        assert_eq!(of("::ffff:10.0.0.1"), of("10.0.0.1"));
    }
}
