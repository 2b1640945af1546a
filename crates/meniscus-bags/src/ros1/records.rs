//! Records of a ROS 1 bag, from its front to its back.

use crate::BagError;
use crate::budget::{Budget, LONGEST};
use crate::cdr::Fields;
use crate::opened::opened;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::time::Instant;

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// Cost of a record at the least, bytes: its header is read into a map.
const RECORD: u64 = 512;

/// Fields of a record's header.
pub(super) type Header<'b> = BTreeMap<&'b str, &'b [u8]>;

/// Taker of a connection (`op` 7) or a message (2): its connection, header and data. It says what is wrong with them.
pub(super) type Taker<'t> = dyn FnMut(Record<'_>) -> Result<(), &'static str> + 't;

/// A connection or a message.
pub(super) enum Record<'b> {
    /// Connection: its number and the fields that describe it.
    Connection(u32, &'b Header<'b>, &'b [u8]),
    /// Message: the number of its connection and its bytes.
    Message(u32, &'b [u8]),
}

/// Reader of records.
pub(super) struct Records {
    path: PathBuf,
    file: BufReader<File>,
    /// Work until the next image.
    pub(super) budget: Budget,
    /// Images that were found, for errors.
    pub(super) images: u64,
}

/// Returns the fields of a record's header.
pub(super) fn header(bytes: &[u8]) -> Option<Header<'_>> {
    let (mut fields, mut found) = (Fields::packed(bytes), BTreeMap::new());
    while let Some(field) = fields.run() {
        let split = field.iter().position(|&byte| byte == b'=')?;
        found.insert(std::str::from_utf8(&field[..split]).ok()?, &field[split + 1..]);
    }
    Some(found)
}

impl Records {
    /// Opens a bag.
    pub(super) fn open(path: &Path) -> Result<Self, BagError> {
        let mut file = BufReader::new(opened(path)?);
        let mut magic = [0; MAGIC.len()];
        if file.read_exact(&mut magic).is_err() || magic != MAGIC {
            return Err(BagError::Damaged {
                path: path.into(),
                why: "it is no ROS bag of version 2.0".into(),
            });
        }
        Ok(Self { path: path.into(), file, budget: Budget::new(), images: 0 })
    }

    /// Returns the error of a file that is damaged behind the images that were found.
    pub(super) fn damaged(&self, why: &str) -> BagError {
        BagError::Damaged { path: self.path.clone(), why: format!("{why}, behind {} images", self.images) }
    }

    /// A length and as many bytes; `None` at the end of the file, if that is `allowed` here.
    fn run(&mut self, allowed: bool) -> Result<Option<Vec<u8>>, BagError> {
        let failed = |cause: std::io::Error, path: &Path, images| match cause.kind() {
            ErrorKind::UnexpectedEof => BagError::Torn { path: path.into(), images },
            _ => BagError::Io { path: path.into(), doing: "read", cause },
        };
        let mut length = [0; 4];
        let mut have = 0;
        while have < 4 {
            match self.file.read(&mut length[have..]) {
                Ok(0) if have == 0 && allowed => return Ok(None),
                Ok(0) => return Err(BagError::Torn { path: self.path.clone(), images: self.images }),
                Ok(read) => have += read,
                Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                Err(cause) => return Err(failed(cause, &self.path, self.images)),
            }
        }
        let length = u32::from_le_bytes(length);
        if length as usize > LONGEST {
            return Err(self.damaged("a record is longer than a record can be"));
        }
        // Not more than there is: a wrong length must not ask for memory.
        let mut bytes = Vec::new();
        let read = self.file.by_ref().take(length.into()).read_to_end(&mut bytes);
        read.map_err(|cause| failed(cause, &self.path, self.images))?;
        if bytes.len() < length as usize {
            return Err(BagError::Torn { path: self.path.clone(), images: self.images });
        }
        Ok(Some(bytes))
    }

    /// Takes a record's bytes and time from the budget.
    fn spend(&mut self, bytes: usize, begun: Instant) -> Result<(), BagError> {
        self.budget.take(bytes, RECORD, begun).map_err(|why| self.damaged(&why))
    }

    /// One record of the file, or all of a chunk, handed to `take`; `false` at the end.
    pub(super) fn chunk(&mut self, take: &mut Taker<'_>) -> Result<bool, BagError> {
        let begun = Instant::now();
        let Some(head) = self.run(true)? else { return Ok(false) };
        let data = self.run(false)?.unwrap_or_default();
        self.spend(head.len() + data.len(), begun)?;
        let fields = header(&head).ok_or_else(|| self.damaged("a record's header is no list of fields"))?;
        if fields.get("op") != Some(&&[5][..]) {
            return self.record(&fields, &data, take).map(|()| true);
        }
        let size =
            fields.get("size").and_then(|size| size.first_chunk()).map(|size| u32::from_le_bytes(*size));
        let limit = size.filter(|size| *size as usize <= LONGEST).unwrap_or(0);
        // The packed bytes go before the records are copied out of the plain ones.
        let plain = match fields.get("compression") {
            Some(&b"none") => data,
            Some(&b"lz4") => self.unpacked(lz4_flex::frame::FrameDecoder::new(&*data), limit, "LZ4")?,
            Some(&b"bz2") => self.unpacked(bzip2::read::MultiBzDecoder::new(&*data), limit, "bzip2")?,
            _ => return Err(self.damaged("a chunk's compression is not known")),
        };
        let mut records = Fields::packed(&plain);
        let mut begun = begun;
        while let (Some(head), Some(data)) = (records.run(), records.run()) {
            self.spend(head.len() + data.len(), begun)?;
            begun = Instant::now();
            let fields =
                header(head).ok_or_else(|| self.damaged("a header in a chunk is no list of fields"))?;
            self.record(&fields, data, take)?;
        }
        Ok(true)
    }

    /// Unpacks a chunk to `limit` bytes at the most.
    fn unpacked(&self, packed: impl Read, limit: u32, by: &str) -> Result<Vec<u8>, BagError> {
        let mut plain = Vec::new();
        let read = packed.take(limit.into()).read_to_end(&mut plain);
        read.map_err(|_| self.damaged(&format!("a chunk that {by} compressed is damaged")))?;
        Ok(plain)
    }

    /// Hands a connection or a message on; anything else is of no use here.
    fn record(&self, fields: &Header<'_>, data: &[u8], take: &mut Taker<'_>) -> Result<(), BagError> {
        let connection = fields.get("conn").and_then(|id| id.first_chunk()).map(|id| u32::from_le_bytes(*id));
        let taken = match (connection, fields.get("op")) {
            (Some(connection), Some(&[7])) => take(Record::Connection(connection, fields, data)),
            (Some(connection), Some(&[2])) => take(Record::Message(connection, data)),
            _ => Ok(()),
        };
        taken.map_err(|why| self.damaged(why))
    }
}
