//! One reader of a byte stream, who may be slow: whole records or nothing.

use std::io::{ErrorKind, Write};

/// Outcome of sending a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    /// It is written, or its rest waits.
    Taken,
    /// The reader has not taken the last one yet: left out.
    LeftOut,
    /// The reader has gone.
    Gone,
}

/// A writer that never blocks, with the rest of a record that it has begun.
#[derive(Debug)]
pub(super) struct Stream<W> {
    writer: W,
    rest: Vec<u8>,
    from: usize,
}

impl<W: Write> Stream<W> {
    /// A stream on a writer that has been set not to block.
    pub(super) fn new(writer: W) -> Self {
        Self { writer, rest: Vec::new(), from: 0 }
    }

    /// Returns the writer.
    pub(super) fn writer(&self) -> &W {
        &self.writer
    }

    /// Writes a record, as far as there is room; the rest goes before the next one.
    pub(super) fn send(&mut self, record: &[u8]) -> Fate {
        if self.flush() == Fate::Gone {
            return Fate::Gone;
        }
        if self.from < self.rest.len() {
            return Fate::LeftOut;
        }
        self.rest.clear();
        self.rest.extend_from_slice(record);
        self.from = 0;
        match self.flush() {
            Fate::Gone => Fate::Gone,
            _ => Fate::Taken,
        }
    }

    /// Writes what is left of the last record, as far as there is room.
    pub(super) fn flush(&mut self) -> Fate {
        while let Some(rest) = self.rest.get(self.from..).filter(|rest| !rest.is_empty()) {
            match self.writer.write(rest) {
                Ok(0) => return Fate::Gone,
                Ok(written) => self.from += written,
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Fate::LeftOut,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return Fate::Gone,
            }
        }
        Fate::Taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes `room` bytes, then none until it is given more.
    struct Narrow {
        room: usize,
        got: Vec<u8>,
    }

    impl Write for Narrow {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            let taken = bytes.len().min(self.room);
            if taken == 0 {
                return Err(ErrorKind::WouldBlock.into());
            }
            self.room -= taken;
            self.got.extend_from_slice(&bytes[..taken]);
            Ok(taken)
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn records_are_whole_or_absent() {
        let mut stream = Stream::new(Narrow { room: 5, got: Vec::new() });
        assert_eq!(stream.send(b"abc"), Fate::Taken);
        assert_eq!(stream.send(b"defg"), Fate::Taken, "two of four fit, two wait");
        assert_eq!(stream.send(b"hi"), Fate::LeftOut);
        stream.writer.room = 100;
        assert_eq!(stream.send(b"jk"), Fate::Taken);
        assert_eq!(stream.writer.got, b"abcdefgjk");
    }
}
