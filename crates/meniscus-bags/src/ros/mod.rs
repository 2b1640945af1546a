//! Camera recordings of other programs: `sensor_msgs/Image` and `sensor_msgs/CameraInfo` in a ROS 1 bag, or in a rosbag2 of MCAP
//! or SQLite.
//!
//! ```text
//! file --Source--> topics, messages --Topics::choose--> depth, outline, camera --Reader--> images
//! ```
//!
//! | file | purpose |
//! |---|---|
//! | `choice` | which topics are read, as a person says it |
//! | `topics` | which topics are read, as the file says it |
//! | `messages` | the two messages, and their pixels |
//! | `source` | topics and messages one after the other; `bag2_mcap`, and `generic` of `ros1` and `db3`, are such |

pub(super) mod bag2_mcap;
mod choice;
mod messages;
mod source;
mod topics;

pub use choice::RosChoice;
pub(super) use source::{Event, Source, Topic};

use self::messages::ImageMessage;
use self::topics::{Chosen, Found};
use super::{BagError, Image, Recording};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;

/// Images that are read before it is decided which are the camera's, and their bytes.
const PATIENCE: usize = 64;
const PATIENCE_BYTES: usize = 48 << 20;

/// Time of the first image, us: an image of the other stream may be a little earlier.
const FIRST_US: u64 = 1_000_000;

/// Opens the recording that `source` reads from `path`.
pub(super) fn open(
    path: &Path,
    mut source: Box<dyn Source>,
    choice: &RosChoice,
) -> Result<Recording, BagError> {
    let mut found = Found::default();
    let mut held = VecDeque::new();
    let (mut bytes, mut ended) = (0, None);
    while held.len() < PATIENCE && bytes <= PATIENCE_BYTES {
        match source.next() {
            Ok(Some(Event::Topic(topic))) => found.add(topic),
            Ok(Some(Event::Message { topic, data })) => match found.look(topic, &data) {
                Ok(true) => {
                    bytes += data.len();
                    source.found_image();
                    held.push_back((topic, data));
                }
                Ok(false) => {}
                Err(fault) => return Err(source.damaged(&fault.to_string())),
            },
            Ok(None) => break,
            // What came before it may be enough.
            Err(error) => {
                ended = Some(error);
                break;
            }
        }
    }
    let chosen = match found.choose(choice) {
        Ok(chosen) => chosen,
        Err(why) => {
            return Err(ended.unwrap_or_else(|| BagError::Topics { path: path.into(), why }));
        }
    };
    let calibration = chosen.calibration.clone();
    if !calibration.is_sound() {
        return Err(source.damaged("its camera cannot be"));
    }
    log::info!("{}: {}", path.display(), found.said(&chosen));
    log::debug!("its camera: {calibration:?}");
    let aligned = found.aligned();
    let reader = Reader {
        source,
        aligned,
        chosen,
        held,
        failed: ended,
        start_us: None,
        counts: BTreeMap::new(),
        ended: false,
    };
    Ok(Recording { calibration, images: Box::new(reader) })
}

struct Reader {
    source: Box<dyn Source>,
    /// Whether messages are aligned, as ROS 2 writes them.
    aligned: BTreeMap<u32, bool>,
    chosen: Chosen,
    /// Messages that were read before the topics were chosen.
    held: VecDeque<(u32, Vec<u8>)>,
    /// Error behind them.
    failed: Option<BagError>,
    start_us: Option<u64>,
    counts: BTreeMap<u32, u32>,
    ended: bool,
}

impl Reader {
    /// Returns the next message of an image topic.
    fn message(&mut self) -> Result<Option<(u32, Vec<u8>)>, BagError> {
        if let Some(held) = self.held.pop_front() {
            return Ok(Some(held));
        }
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        loop {
            match self.source.next()? {
                None => return Ok(None),
                Some(Event::Message { topic, data }) if self.chosen.stream(topic).is_some() => {
                    self.source.found_image();
                    return Ok(Some((topic, data)));
                }
                Some(_) => {}
            }
        }
    }

    fn image(&mut self) -> Result<Option<Image>, BagError> {
        while let Some((topic, data)) = self.message()? {
            let Some(stream) = self.chosen.stream(topic) else { continue };
            let aligned = self.aligned.get(&topic).copied().unwrap_or_default();
            let image = ImageMessage::read(&data, aligned)
                .and_then(|message| {
                    Ok((message.stamp_us, message.pixels(stream, self.chosen.calibration.size)?))
                })
                .map_err(|fault| self.source.damaged(&fault.to_string()))?;
            let (stamp_us, pixels) = image;
            let start_us = *self.start_us.get_or_insert(stamp_us);
            let captured = Micros((FIRST_US + stamp_us).saturating_sub(start_us));
            let count = self.counts.entry(topic).or_default();
            let stamp = Stamp { sequence: *count, captured };
            *count = count.wrapping_add(1);
            return Ok(Some(Image { stream, stamp, pixels }));
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
