//! rosbag2 in MCAP: channels whose messages are in CDR, or in the form of ROS 1.

use super::source::{Event, Source, Topic};
use crate::BagError;
use crate::budget::Budget;
use crate::mcap_records::Records;
use mcap::records::Record;
use std::collections::BTreeMap;
use std::path::Path;

/// Schemas at most.
const MOST: usize = 4096;

/// rosbag2 in MCAP.
pub(crate) struct Bag {
    records: Records,
    /// Names of the schemas.
    schemas: BTreeMap<u16, String>,
}

impl Bag {
    /// Opens a file.
    pub(crate) fn open(path: &Path) -> Result<Self, BagError> {
        Ok(Self { records: Records::open(path)?, schemas: BTreeMap::new() })
    }
}

impl Source for Bag {
    fn next(&mut self) -> Result<Option<Event>, BagError> {
        while let Some(record) = self.records.next()? {
            match record {
                Record::Schema { header, .. } if self.schemas.len() < MOST => {
                    self.schemas.insert(header.id, header.name);
                }
                Record::Channel(channel) => {
                    let aligned = match channel.message_encoding.as_str() {
                        "cdr" => true,
                        "ros1" => false,
                        _ => continue,
                    };
                    let kind = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                    let topic = Topic { id: channel.id.into(), name: channel.topic, kind, aligned };
                    return Ok(Some(Event::Topic(topic)));
                }
                Record::Message { header, data } => {
                    let topic = header.channel_id.into();
                    return Ok(Some(Event::Message { topic, data: data.into_owned() }));
                }
                _ => {}
            }
        }
        Ok(None)
    }

    fn found_image(&mut self) {
        self.records.images += 1;
        self.records.budget = Budget::new();
    }

    fn damaged(&self, why: &str) -> BagError {
        self.records.damaged(format!("{why}, behind {} images", self.records.images))
    }
}
