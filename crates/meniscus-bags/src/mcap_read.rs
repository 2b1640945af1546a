//! Reading the MCAP files that [`McapWriter`](super::McapWriter) writes, chunk by chunk, without their index.

use super::budget::Budget;
use super::mcap_records::Records;
use super::mcap_write::{DEPTH_TOPIC, METADATA, OUTLINE_TOPICS};
use super::schema::RawImage;
use super::{BagError, Calibration, Image, Recording, image_bytes};
use mcap::records::Record;
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use prost::Message;
use std::collections::BTreeMap;
use std::path::Path;

/// Opens a file.
pub(super) fn open(path: &Path) -> Result<Recording, BagError> {
    let records = Records::open(path)?;
    let mut reader = Reader { records, streams: BTreeMap::new(), calibration: None, ended: false };
    // The camera stands before the first image.
    while reader.calibration.is_none() {
        match reader.records.next()? {
            Some(Record::Metadata(found)) if found.name == METADATA => {
                let text = found.metadata.get("calibration").map_or("", String::as_str);
                let read: Option<Calibration> = serde_json::from_str(text).ok().filter(Calibration::is_sound);
                let damaged = || reader.records.damaged("its camera cannot be".into());
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
    records: Records,
    /// Which channel is which stream.
    streams: BTreeMap<u16, Stream>,
    calibration: Option<Calibration>,
    ended: bool,
}

impl Reader {
    fn image(&mut self) -> Result<Option<Image>, BagError> {
        while let Some(record) = self.records.next()? {
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
                    let message =
                        RawImage::decode(&*data).map_err(|why| self.records.damaged(why.to_string()))?;
                    let wanted = self.calibration.as_ref().map_or(0, |camera| image_bytes(camera, stream));
                    if message.data.len() != wanted {
                        let why = format!("an image of {} bytes instead of {wanted}", message.data.len());
                        return Err(self.records.damaged(why));
                    }
                    let captured = Micros(header.publish_time / 1000);
                    self.records.images += 1;
                    self.records.budget = Budget::new();
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
