//! ROS 1 bags of any program, as topics and messages.

use super::records::{Header, Record, Records, header};
use crate::BagError;
use crate::budget::Budget;
use crate::ros::{Event, Source, Topic};
use std::collections::VecDeque;
use std::path::Path;

/// Bag of any program.
pub(crate) struct Bag {
    records: Records,
    ready: VecDeque<Event>,
}

impl Bag {
    /// Opens a bag.
    pub(crate) fn open(path: &Path) -> Result<Self, BagError> {
        Ok(Self { records: Records::open(path)?, ready: VecDeque::new() })
    }

    /// Returns whether librealsense recorded the bag, by the first topic.
    pub(crate) fn is_librealsense(path: &Path) -> Result<bool, BagError> {
        let mut bag = Self::open(path)?;
        while let Some(event) = bag.next()? {
            if let Event::Topic(topic) = event {
                let depth = topic.name.contains("/Depth_0/") || topic.name.contains("/Infrared_1/");
                if depth || topic.name.starts_with("/device_") || topic.name == "/file_version" {
                    return Ok(true);
                }
                if topic.kind.starts_with("sensor_msgs/") {
                    return Ok(false);
                }
            }
        }
        // A bag without a topic: the reader of librealsense's bags says what is missing.
        Ok(true)
    }
}

fn topic(id: u32, fields: &Header<'_>, data: &[u8]) -> Option<Topic> {
    let text = |bytes: &[u8]| std::str::from_utf8(bytes).ok().map(str::to_owned);
    // The type stands in a second header, the data of the record.
    let described = header(data)?;
    let name = text(fields.get("topic")?)?;
    Some(Topic { id, name, kind: text(described.get("type")?)?, aligned: false })
}

impl Source for Bag {
    fn next(&mut self) -> Result<Option<Event>, BagError> {
        let Self { records, ready } = self;
        while ready.is_empty() {
            let more = records.chunk(&mut |record| {
                match record {
                    Record::Connection(id, fields, data) => {
                        ready.extend(topic(id, fields, data).map(Event::Topic));
                    }
                    Record::Message(topic, data) => {
                        ready.push_back(Event::Message { topic, data: data.to_vec() });
                    }
                }
                Ok(())
            })?;
            if !more {
                break;
            }
        }
        Ok(ready.pop_front())
    }

    fn found_image(&mut self) {
        self.records.images += 1;
        self.records.budget = Budget::new();
    }

    fn damaged(&self, why: &str) -> BagError {
        self.records.damaged(why)
    }
}
