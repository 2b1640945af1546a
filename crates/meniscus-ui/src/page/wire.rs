//! One connection of the page: plain, or encrypted.

use crate::listener::TimedStream;
use std::io::{Read, Result, Write};
use std::net::{Shutdown, TcpStream};
use std::time::Duration;

/// A connection with a deadline. The handshake of an encrypted one is part of its first read.
pub(super) enum Wire {
    /// As it is.
    Plain(TimedStream),
    /// TLS.
    #[cfg(feature = "tls")]
    Encrypted(Box<rustls::StreamOwned<rustls::ServerConnection, TimedStream>>),
}

impl Wire {
    /// Gives the peer `patience` from now on.
    pub(super) fn allow(&mut self, patience: Duration) {
        match self {
            Self::Plain(stream) => stream.allow(patience),
            #[cfg(feature = "tls")]
            Self::Encrypted(stream) => stream.sock.allow(patience),
        }
    }

    /// Says that nothing more comes from here.
    pub(super) fn finish(&mut self) {
        #[cfg(feature = "tls")]
        if let Self::Encrypted(stream) = self {
            stream.conn.send_close_notify();
            // A peer that has gone needs no farewell.
            let _gone = stream.flush();
        }
        let _gone = self.socket().shutdown(Shutdown::Write);
    }

    fn socket(&self) -> &TcpStream {
        match self {
            Self::Plain(stream) => stream.socket(),
            #[cfg(feature = "tls")]
            Self::Encrypted(stream) => stream.sock.socket(),
        }
    }
}

impl Read for Wire {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        match self {
            Self::Plain(stream) => stream.read(into),
            #[cfg(feature = "tls")]
            Self::Encrypted(stream) => stream.read(into),
        }
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        match self {
            Self::Plain(stream) => stream.write(bytes),
            #[cfg(feature = "tls")]
            Self::Encrypted(stream) => stream.write(bytes),
        }
    }

    fn flush(&mut self) -> Result<()> {
        match self {
            Self::Plain(stream) => stream.flush(),
            #[cfg(feature = "tls")]
            Self::Encrypted(stream) => stream.flush(),
        }
    }
}
