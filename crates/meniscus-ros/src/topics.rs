//! The topics with their quality of service.
//!
//! Every topic is offered as reliable, and each reader chooses: one of sensor data (best effort) is sent each message once, one
//! that asks for reliability gets lost parts again. A best-effort offer would not serve the latter, which is RViz's default, and a
//! cloud of 111 kB is 434 fragments: where one is lost, the cloud is. Nothing waits: the newest messages replace those that a
//! reader has not fetched, and one that the middleware does not take at once is counted.

use crate::counters::{Counters, count};
use crate::error::RosError;
use crate::message::{DiagnosticArray, Estimate, PointCloud2, TransformMessage};
use ros2_client::qos::{History, WhenFull};
use ros2_client::{MessageTypeName, Name, Node, Publisher, QosProfile};
use serde::Serialize;
use std::sync::Arc;

/// Publishers of the topics.
pub(crate) struct Topics {
    pub(crate) tracers: Topic<PointCloud2>,
    pub(crate) surface: Topic<PointCloud2>,
    pub(crate) estimate: Topic<Estimate>,
    pub(crate) transforms: Topic<TransformMessage>,
    pub(crate) diagnostics: Topic<DiagnosticArray>,
}

/// Publisher of one topic.
pub(crate) struct Topic<M: Serialize> {
    name: &'static str,
    publisher: Publisher<M>,
    counters: Arc<Counters>,
}

/// Name, type and quality of a topic.
struct Wanted {
    space: &'static str,
    name: &'static str,
    package: &'static str,
    kind: &'static str,
    qos: QosProfile,
}

/// Depth of the clouds, half a second: lost parts of one come again after 50 to 150 ms.
const CLOUDS: usize = 30;

/// Reliable, as long as a reader is less than `depth` messages behind.
fn reliable(depth: usize) -> QosProfile {
    QosProfile::publisher_default().reliability_reliable(WhenFull::Fail).history(History::KeepLast { depth })
}

impl Topics {
    /// Opens all topics.
    pub(crate) fn open(node: &mut Node, counters: &Arc<Counters>) -> Result<Self, RosError> {
        let wanted = |space, name, package, kind, qos| Wanted { space, name, package, kind, qos };
        let mut of = Opening { node, counters };
        Ok(Self {
            tracers: of.topic(wanted(
                "/liquid",
                "tracers",
                "sensor_msgs",
                "PointCloud2",
                reliable(CLOUDS),
            ))?,
            surface: of.topic(wanted(
                "/liquid",
                "surface",
                "sensor_msgs",
                "PointCloud2",
                reliable(CLOUDS),
            ))?,
            estimate: of.topic(wanted("/liquid", "estimate", "meniscus_msgs", "Estimate", reliable(60)))?,
            transforms: of.topic(wanted("/", "tf", "tf2_msgs", "TFMessage", reliable(100)))?,
            diagnostics: of.topic(wanted(
                "/",
                "diagnostics",
                "diagnostic_msgs",
                "DiagnosticArray",
                reliable(10),
            ))?,
        })
    }

    /// Returns the topics with the number of their readers.
    pub(crate) fn readers(&self, node: &Node) -> [(&'static str, usize); 5] {
        [
            self.tracers.readers(node),
            self.surface.readers(node),
            self.estimate.readers(node),
            self.transforms.readers(node),
            self.diagnostics.readers(node),
        ]
    }
}

/// A node whose topics are being opened.
struct Opening<'n> {
    node: &'n mut Node,
    counters: &'n Arc<Counters>,
}

impl Opening<'_> {
    fn topic<M: Serialize>(&mut self, wanted: Wanted) -> Result<Topic<M>, RosError> {
        let Wanted { space, name, package, kind, qos } = wanted;
        let full = Name::new(space, name).map_err(|error| RosError::Name(error.to_string()))?;
        let topic = self.node.create_topic(&full, MessageTypeName::new(package, kind), &qos)?;
        let publisher = self.node.create_publisher(&topic, Some(qos))?;
        Ok(Topic { name, publisher, counters: Arc::clone(self.counters) })
    }
}

impl<M: Serialize> Topic<M> {
    /// Publishes a message; one that the middleware does not take is counted.
    pub(crate) fn publish(&self, message: M) {
        if self.publisher.publish(message).is_err() {
            count(&self.counters.refused);
        }
    }

    fn readers(&self, node: &Node) -> (&'static str, usize) {
        (self.name, self.publisher.get_subscription_count(node))
    }
}
