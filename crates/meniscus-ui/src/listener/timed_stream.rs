//! Connection whose reads and writes all end at one instant, however they are cut into pieces.
//!
//! A socket's own time limit begins anew with every byte. A peer that sends one byte within each limit would never end.

use std::io::{ErrorKind, Read, Result, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A connection with a deadline.
#[derive(Debug)]
pub(crate) struct TimedStream {
    stream: Arc<TcpStream>,
    deadline: Instant,
}

impl TimedStream {
    /// Returns `stream` with `patience` left.
    pub(crate) fn new(stream: Arc<TcpStream>, patience: Duration) -> Self {
        Self { stream, deadline: Instant::now() + patience }
    }

    /// Gives the peer `patience` from now on.
    pub(crate) fn allow(&mut self, patience: Duration) {
        self.deadline = Instant::now() + patience;
    }

    /// Returns the connection itself.
    pub(crate) fn socket(&self) -> &TcpStream {
        &self.stream
    }

    /// Waits for bytes and copies them to `into`, unread; returns their number.
    pub(crate) fn peek(&self, into: &mut [u8]) -> Result<usize> {
        self.until_deadline(|stream, left| {
            stream.set_read_timeout(left)?;
            stream.peek(into)
        })
    }

    /// Returns the time left; none is an error.
    fn left(&self) -> Result<Option<Duration>> {
        let left = self.deadline.saturating_duration_since(Instant::now());
        if left.is_zero() { Err(ErrorKind::TimedOut.into()) } else { Ok(Some(left)) }
    }

    /// Calls `act` with the time left, again where a signal interrupted it: a program that was stopped and continued keeps
    /// its viewers.
    fn until_deadline(
        &self,
        mut act: impl FnMut(&TcpStream, Option<Duration>) -> Result<usize>,
    ) -> Result<usize> {
        loop {
            match act(&self.stream, self.left()?) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                done => return done,
            }
        }
    }
}

impl Read for TimedStream {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        self.until_deadline(|stream, left| {
            stream.set_read_timeout(left)?;
            { stream }.read(into)
        })
    }
}

impl Write for TimedStream {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.until_deadline(|stream, left| {
            stream.set_write_timeout(left)?;
            { stream }.write(bytes)
        })
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    /// One byte every 50 ms would renew a plain limit of 200 ms for ever.
    #[test]
    fn trickled_bytes_do_not_renew_the_deadline() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let mut peer = TcpStream::connect(listener.local_addr().expect("an address")).expect("connected");
        let (stream, _) = listener.accept().expect("accepted");
        std::thread::spawn(move || {
            while peer.write_all(b"x").is_ok() {
                std::thread::sleep(Duration::from_millis(50));
            }
        });
        let mut stream = TimedStream::new(Arc::new(stream), Duration::from_millis(200));
        let begun = Instant::now();
        let fault = std::io::copy(&mut stream, &mut std::io::sink()).expect_err("it ends");
        assert!(matches!(fault.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock), "{fault}");
        let took = begun.elapsed();
        assert!(took >= Duration::from_millis(150) && took < Duration::from_secs(5), "{took:?}");
    }

    /// A connection whose peer says nothing, with its peer.
    fn silent(patience: Duration) -> (TimedStream, TcpStream) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let peer = TcpStream::connect(listener.local_addr().expect("an address")).expect("connected");
        let (stream, _) = listener.accept().expect("accepted");
        (TimedStream::new(Arc::new(stream), patience), peer)
    }

    #[test]
    fn a_call_that_a_signal_interrupts_is_made_again() {
        let (stream, _peer) = silent(Duration::from_secs(60));
        let mut calls = 0;
        let done = stream.until_deadline(|_, left| {
            calls += 1;
            assert!(left.is_some_and(|left| !left.is_zero()), "each call has the time that is left");
            if calls < 3 { Err(ErrorKind::Interrupted.into()) } else { Ok(7) }
        });
        assert_eq!((done.ok(), calls), (Some(7), 3));
    }

    #[test]
    fn signals_do_not_renew_the_deadline() {
        let (stream, _peer) = silent(Duration::from_millis(50));
        let fault = stream.until_deadline(|_, _| Err(ErrorKind::Interrupted.into())).expect_err("it ends");
        assert_eq!(fault.kind(), ErrorKind::TimedOut);
    }

    #[test]
    fn other_faults_are_handed_on() {
        let (stream, _peer) = silent(Duration::from_secs(60));
        let fault =
            stream.until_deadline(|_, _| Err(ErrorKind::ConnectionReset.into())).expect_err("a fault");
        assert_eq!(fault.kind(), ErrorKind::ConnectionReset);
    }
}
