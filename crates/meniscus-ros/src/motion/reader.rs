//! Thread that reads the topic: it looks for the type of its publishers, subscribes, and hands samples in.

use super::kind::{Kind, absence};
use super::sample::{MotionMessage, Reading};
use super::wait::next_within;
use super::{MotionTopic, RosMotion};
use crate::message::{Imu, JointState, Odometry, PoseStamped, TransformMessage, TransformStamped};
use meniscus_service::commanded_motion::{MotionInlet, SampleFault, SenderId};
use ros2_client::dds::Subscription;
use ros2_client::dds::rustdds::{DomainParticipant, RTPSEntity};
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{CreateError, MessageInfo, MessageTypeName, Name, Node, QosProfile};
use std::pin::pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time between two looks at the state of the topic.
const PAUSE: Duration = Duration::from_millis(100);

/// Time without a sample after which the reason is reported.
const ABSENT: Duration = Duration::from_secs(3);

/// Messages that wait for the thread at the most.
const DEPTH: usize = 100;

/// Bytes of a writer's identifier that name its participant.
const PARTICIPANT: usize = 12;

/// Fixed frames.
const STATIC: &str = "/tf_static";

/// The reader of a topic.
pub(crate) struct MotionReader<'r> {
    participant: DomainParticipant,
    topic: &'r MotionTopic,
    inlet: &'r mut MotionInlet,
    reading: Reading<'r>,
    subscribed: Option<Kind>,
    /// When a sample or a fault was there at last; at first when the run began.
    heard: Instant,
    /// Samples that were handed in.
    taken: u32,
    /// Messages that were refused, and are not lost.
    refused: u32,
}

impl<'r> MotionReader<'r> {
    /// Returns the reader of `motion` in the domain of `participant`.
    pub(crate) fn of(motion: &'r mut RosMotion, participant: DomainParticipant) -> Self {
        let RosMotion { topic, inlet } = motion;
        let reading = Reading::of(topic);
        Self {
            participant,
            topic,
            inlet,
            reading,
            subscribed: None,
            heard: Instant::now(),
            taken: 0,
            refused: 0,
        }
    }

    /// Reads until `closing` is set.
    pub(crate) fn run(mut self, node: &Mutex<Node>, closing: &AtomicBool) {
        while !closing.load(Ordering::Relaxed) {
            self.subscribed = self.kind(&self.types());
            let read = match self.subscribed {
                Some(Kind::Odometry) => self.listen::<Odometry>(node, closing),
                Some(Kind::Pose) => self.listen::<PoseStamped>(node, closing),
                Some(Kind::Transform) => self.listen::<TransformStamped>(node, closing),
                Some(Kind::Transforms) => self.listen::<TransformMessage>(node, closing),
                Some(Kind::Imu) => self.listen::<Imu>(node, closing),
                Some(Kind::Joints) => self.listen::<JointState>(node, closing),
                None => {
                    std::thread::sleep(PAUSE);
                    Ok(())
                }
            };
            if let Err(error) = read {
                let why = format!("{} cannot be subscribed to: {error}", self.topic.topic);
                self.inlet.refuse(&SampleFault::Absent(why));
                std::thread::sleep(PAUSE);
            }
            self.look();
        }
    }

    /// Returns the types of the topic's publishers, as DDS names them.
    fn types(&self) -> Vec<String> {
        let topic = format!("rt{}", self.topic.topic);
        let writers = self.participant.discovered_writers();
        let of_topic = writers.into_iter().map(|writer| writer.publication_topic_data);
        let mut types: Vec<String> =
            of_topic.filter(|data| data.topic_name == topic).map(|data| data.type_name).collect();
        types.sort_unstable();
        types.dedup();
        types
    }

    /// Returns the type to read: the present one, as long as somebody publishes it.
    fn kind(&self, seen: &[String]) -> Option<Kind> {
        let mut readable = seen.iter().filter_map(|name| Kind::of_dds(name));
        let stays = self.subscribed.filter(|kind| readable.clone().any(|seen| seen == *kind));
        stays.or_else(|| readable.next())
    }

    /// Opens a subscription. It takes what is sent once: a lost sample is of no use when it comes again.
    fn subscribe<M: MotionMessage>(
        node: &Mutex<Node>,
        topic: &str,
        qos: QosProfile,
    ) -> Result<Subscription<M>, CreateError> {
        let mut node = node.lock().unwrap_or_else(PoisonError::into_inner);
        let (package, kind) = M::TYPE;
        let name = Name::parse(topic).map_err(|error| CreateError::Internal { reason: error.to_string() })?;
        let topic = node.create_topic(&name, MessageTypeName::new(package, kind), &qos)?;
        node.create_subscription(&topic, Some(qos))
    }

    /// Reads messages of a type until `closing` is set, or the publishers have another type.
    fn listen<M: MotionMessage>(
        &mut self,
        node: &Mutex<Node>,
        closing: &AtomicBool,
    ) -> Result<(), CreateError> {
        let qos = QosProfile::subscription_default().history(History::KeepLast { depth: DEPTH });
        let subscription = Self::subscribe::<M>(node, &self.topic.topic, qos.clone())?;
        let statics = if self.subscribed == Some(Kind::Transforms) {
            let kept = qos.reliability_reliable(WhenFull::Fail).durability(Durability::TransientLocal);
            Some(Self::subscribe::<TransformMessage>(node, STATIC, kept)?)
        } else {
            None
        };
        let mut messages = pin!(subscription.async_stream());
        while !closing.load(Ordering::Relaxed) {
            let came = next_within(messages.as_mut(), PAUSE);
            while let Some(Ok(Some((message, _)))) = statics.as_ref().map(Subscription::take) {
                self.reading.transforms.take_static(&message);
            }
            match came {
                Some(Ok((message, info))) => self.take(message, &info),
                Some(Err(error)) => {
                    self.heard = Instant::now();
                    let why = format!("its bytes are no {}/msg/{}: {error}", M::TYPE.0, M::TYPE.1);
                    self.inlet.refuse(&SampleFault::Malformed(why));
                }
                None => {}
            }
            if self.look() && self.kind(&self.types()) != self.subscribed {
                break;
            }
        }
        Ok(())
    }

    /// Takes a message.
    fn take<M: MotionMessage>(&mut self, message: M, info: &MessageInfo) {
        let from = info.publisher_gid().to_bytes16();
        // The node itself publishes on /tf.
        if self.participant.guid().prefix.as_ref() == &from[..PARTICIPANT] {
            return;
        }
        let (clock, inlet, taken) = (self.topic.clock, &mut *self.inlet, &mut self.taken);
        let (heard, refused) = (&mut self.heard, &mut self.refused);
        // All links of a chain together are one sender: each is asked for its publisher by itself.
        let sender =
            if self.subscribed == Some(Kind::Transforms) { SenderId::default() } else { SenderId(from) };
        message.read(SenderId(from), &mut self.reading, &mut |given| {
            *heard = Instant::now();
            let frame = given.and_then(|sample| {
                // The low half of the number of DDS: only differences count.
                let whole = (info.sequence_number() as u32).wrapping_sub(*refused);
                let sequence = if M::IS_WHOLE { whole } else { *taken };
                let frame = sample.frame(clock, sequence);
                frame.check().map(|()| frame).map_err(SampleFault::from)
            });
            match frame {
                Ok(frame) => {
                    *taken = taken.wrapping_add(1);
                    inlet.take(sender, &frame);
                }
                Err(fault) => {
                    *refused = refused.wrapping_add(1);
                    inlet.refuse(&fault);
                }
            }
        });
        if let Some(notice) = self.reading.notice.take() {
            self.inlet.say(&notice);
        }
    }

    /// Looks after the state of the source; returns whether nothing has come for seconds, which is reported.
    fn look(&mut self) -> bool {
        self.inlet.look();
        if self.heard.elapsed() < ABSENT {
            return false;
        }
        self.heard = Instant::now();
        let why = absence(&self.reading, &self.types(), self.subscribed);
        self.inlet.refuse(&SampleFault::Absent(why));
        true
    }
}
