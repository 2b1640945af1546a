//! Reading the MCAP files that [`McapWriter`](super::McapWriter) writes, chunk by chunk, without their index.

use super::budget::{Budget, LONGEST};
use super::mcap_write::{DEPTH_TOPIC, METADATA, OUTLINE_TOPICS};
use super::schema::RawImage;
use super::{BagError, Calibration, Image, Recording, image_bytes};
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_platform::files::{Links, open_regular};
use prost::Message;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Cost of a record at the least, bytes: it is parsed into maps and texts.
const RECORD: u64 = 512;
/// Most bytes read at once.
const READ: usize = 1 << 20;

/// Opens a file.
pub(super) fn open(path: &Path) -> Result<Recording, BagError> {
    let file = open_regular(path, Links::Followed).map_err(|cause| BagError::Io {
        path: path.into(),
        doing: "open",
        cause,
    })?;
    let options =
        LinearReaderOptions::default().with_prevalidate_chunk_crcs(true).with_record_length_limit(LONGEST);
    let mut reader = Reader {
        path: path.into(),
        file,
        records: LinearReader::new_with_options(options),
        streams: BTreeMap::new(),
        calibration: None,
        budget: Budget::new(),
        images: 0,
        ended: false,
    };
    // The camera stands before the first image.
    while reader.calibration.is_none() {
        match reader.record()? {
            Some(Record::Metadata(found)) if found.name == METADATA => {
                let text = found.metadata.get("calibration").map_or("", String::as_str);
                let read: Option<Calibration> = serde_json::from_str(text).ok().filter(Calibration::is_sound);
                let damaged = || reader.damaged("its camera cannot be".into());
                reader.calibration = Some(read.ok_or_else(damaged)?);
            }
            Some(Record::Message { .. }) | None => {
                return Err(BagError::Lacks {
                    path: path.into(),
                    what: "record of its camera (meniscus.camera)",
                });
            }
            Some(_) => {}
        }
    }
    let calibration = reader.calibration.clone();
    let calibration =
        calibration.ok_or(BagError::Lacks { path: path.into(), what: "record of its camera" })?;
    Ok(Recording { calibration, images: Box::new(reader) })
}

struct Reader {
    path: PathBuf,
    file: File,
    records: LinearReader,
    /// Which channel is which stream.
    streams: BTreeMap<u16, Stream>,
    calibration: Option<Calibration>,
    /// Work until the next image.
    budget: Budget,
    images: u64,
    ended: bool,
}

impl Reader {
    fn damaged(&self, why: String) -> BagError {
        BagError::Damaged { path: self.path.clone(), why }
    }

    /// The next record; `None` at the end.
    fn record(&mut self) -> Result<Option<Record<'static>>, BagError> {
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

    fn image(&mut self) -> Result<Option<Image>, BagError> {
        while let Some(record) = self.record()? {
            match record {
                Record::Channel(channel) => {
                    let stream = match channel.topic.as_str() {
                        DEPTH_TOPIC => Some(Stream::Depth),
                        other => {
                            OUTLINE_TOPICS.iter().any(|(_, topic)| *topic == other).then_some(Stream::Outline)
                        }
                    };
                    self.streams.extend(stream.map(|stream| (channel.id, stream)));
                }
                Record::Message { header, data } => {
                    let Some(&stream) = self.streams.get(&header.channel_id) else { continue };
                    let message = RawImage::decode(&*data).map_err(|why| self.damaged(why.to_string()))?;
                    let wanted = self.calibration.as_ref().map_or(0, |camera| image_bytes(camera, stream));
                    if message.data.len() != wanted {
                        let why = format!("an image of {} bytes instead of {wanted}", message.data.len());
                        return Err(self.damaged(why));
                    }
                    let captured = Micros(header.publish_time / 1000);
                    self.images += 1;
                    self.budget = Budget::new();
                    return Ok(Some(Image {
                        stream,
                        stamp: Stamp { sequence: header.sequence, captured },
                        pixels: message.data,
                    }));
                }
                _ => {}
            }
        }
        Ok(None)
    }
}

impl Iterator for Reader {
    type Item = Result<Image, BagError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let image = self.image().transpose();
        self.ended = !matches!(image, Some(Ok(_)));
        image
    }
}
