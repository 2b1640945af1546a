//! Records of an MCAP file, in the order in which they were written, without their index.

use super::BagError;
use super::budget::{Budget, LONGEST};
use super::opened::opened;
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Cost of a record at the least, bytes: it is parsed into maps and texts.
const RECORD: u64 = 512;
/// Most bytes read at once.
const READ: usize = 1 << 20;

/// Records of a file, chunk by chunk.
pub(super) struct Records {
    path: PathBuf,
    file: File,
    records: LinearReader,
    /// Work until the next image.
    pub(super) budget: Budget,
    /// Images that were found, for errors.
    pub(super) images: u64,
}

impl Records {
    /// Opens a file.
    pub(super) fn open(path: &Path) -> Result<Self, BagError> {
        let file = opened(path)?;
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(LONGEST);
        let records = LinearReader::new_with_options(options);
        Ok(Self { path: path.into(), file, records, budget: Budget::new(), images: 0 })
    }

    /// Returns the error of a file that is damaged.
    pub(super) fn damaged(&self, why: String) -> BagError {
        BagError::Damaged { path: self.path.clone(), why }
    }

    /// The next record; `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<Record<'static>>, BagError> {
        let begun = Instant::now();
        loop {
            let wanted = match self.records.next_event() {
                None => return Ok(None),
                Some(Ok(LinearReadEvent::ReadRequest(bytes))) => bytes,
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    let bytes = data.len();
                    let record = mcap::parse_record(opcode, data).map(Record::into_owned);
                    if let Err(why) = self.budget.take(bytes, RECORD, begun) {
                        return Err(self.damaged(why));
                    }
                    return record.map(Some).map_err(|why| self.damaged(why.to_string()));
                }
                // Whatever is wrong here, it is the end of what can be read.
                Some(Err(_)) => return Err(BagError::Torn { path: self.path.clone(), images: self.images }),
            };
            let room = self.records.insert(wanted.clamp(1, READ));
            let read = self.file.read(room);
            let read =
                read.map_err(|cause| BagError::Io { path: self.path.clone(), doing: "read", cause })?;
            self.records.notify_read(read);
        }
    }
}
