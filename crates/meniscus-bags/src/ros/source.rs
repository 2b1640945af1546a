//! Topics and messages of a file, one after the other.

use crate::BagError;

/// Topic of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Topic {
    /// Number by which messages name it.
    pub(crate) id: u32,
    /// Name.
    pub(crate) name: String,
    /// Type of its messages, `sensor_msgs/Image` or `sensor_msgs/msg/Image`.
    pub(crate) kind: String,
    /// Whether messages are aligned, as ROS 2 writes them, or packed, as ROS 1 does.
    pub(crate) aligned: bool,
}

/// Part of a file.
#[derive(Debug)]
pub(crate) enum Event {
    /// A topic, before its first message.
    Topic(Topic),
    /// A message.
    Message {
        /// Number of its topic.
        topic: u32,
        /// Bytes.
        data: Vec<u8>,
    },
}

/// Reader of a file, from its beginning to its end.
pub(crate) trait Source: Send {
    /// Returns the next part; none at the end.
    fn next(&mut self) -> Result<Option<Event>, BagError>;

    /// Begins a new budget, as an image was found.
    fn found_image(&mut self);

    /// Returns the error of a message that cannot be read.
    fn damaged(&self, why: &str) -> BagError;
}
