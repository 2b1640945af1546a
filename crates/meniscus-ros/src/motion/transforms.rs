//! `/tf` and `/tf_static`: the position of the glass in a parent frame, along a chain of frames.
//!
//! ```text
//! T_parent_child(t) = (T_1(t) T_2(t) ...)^-1 (T_1'(t) T_2'(t) ...)     from the frame that both chains have above them
//! ```
//! Each `T_k` is a link, stated by a publisher at its own instants. A sample is taken at the instants of the link that comes most
//! seldom, and the others are interpolated: positions between two stated ones would have a bend at each. So a sample waits for
//! the slowest link, and nothing is extrapolated.

use super::links::{Link, Links, Stated};
use super::rotation::{rotation, vector};
use super::stamped::{Give, Sample, stamp_ns};
use super::{FramePair, plain};
use crate::message::{TransformMessage, TransformStamped};
use meniscus_service::commanded_motion::{SampleFault, SenderId, StampClock};
use nalgebra::Isometry3;
use std::collections::VecDeque;
use std::time::{SystemTime, UNIX_EPOCH};

/// Time by which a stamp may be ahead of the host's clock, ns: that of the source of stamped samples.
const AHEAD_NS: u64 = 100_000_000;

/// Instants that wait for the other links.
const PENDING_MOST: usize = 64;

/// Share by which another link has to come more seldom to give the instants.
const SELDOM: f64 = 1.2;

/// The frames, and the instants that a sample is due at.
#[derive(Debug)]
pub(super) struct Transforms {
    pair: Option<FramePair>,
    clock: StampClock,
    links: Links,
    /// Child frame of the link that gives the instants.
    leader: String,
    pending: VecDeque<u64>,
}

/// Returns a frame's name as tf2 has it.
fn name(frame: &str) -> &str {
    frame.trim_start_matches('/')
}

impl Transforms {
    pub(super) fn of(pair: Option<&FramePair>, clock: StampClock) -> Self {
        let pair = pair.map(|FramePair { parent, child }| FramePair {
            parent: name(parent).into(),
            child: name(child).into(),
        });
        Self { pair, clock, links: Links::default(), leader: String::new(), pending: VecDeque::new() }
    }

    /// Returns the frames that were seen.
    pub(super) fn frames(&self) -> Vec<&str> {
        self.links.frames()
    }

    /// Whether a chain joins both frames.
    pub(super) fn is_joined(&self) -> bool {
        self.pair.as_ref().is_some_and(|pair| self.links.chain(pair).is_some())
    }

    /// Takes the links of `/tf_static`.
    pub(super) fn take_static(&mut self, message: &TransformMessage) {
        for transform in &message.transforms {
            // One that is none leaves its frames apart, which is reported.
            if let Ok(rigid) = rigid(transform) {
                self.links.fix(name(&transform.header.frame_id), name(&transform.child_frame_id), rigid);
            }
        }
    }

    /// Takes the links of `/tf`, and gives the samples that they complete.
    pub(super) fn take(&mut self, message: &TransformMessage, from: SenderId, give: Give<'_>) {
        let Some(pair) = self.pair.clone() else { return };
        let mut instants = Vec::new();
        for transform in &message.transforms {
            let child = name(&transform.child_frame_id);
            let concerns =
                child == pair.child || self.links.chain(&pair).is_some_and(|chain| chain.has(child));
            match self.link(transform, from) {
                Ok(Some(stamp_ns)) => instants.push((child, stamp_ns)),
                Ok(None) => {}
                Err(Fault::Sample(fault)) if concerns => give(Err(fault)),
                // The source refuses it by its stamp.
                Err(Fault::Future(sample)) if concerns => give(Ok(sample)),
                // Other robots' frames are their own matter.
                Err(_) => {}
            }
        }
        self.choose_leader(&pair);
        let due = instants.iter().filter(|(child, _)| *child == self.leader).map(|(_, stamp_ns)| *stamp_ns);
        self.pending.extend(due);
        while self.pending.len() > PENDING_MOST {
            self.pending.pop_front();
        }
        self.give_due(&pair, give);
    }

    /// Takes one link; returns its stamp where it is new.
    fn link(&mut self, transform: &TransformStamped, from: SenderId) -> Result<Option<u64>, Fault> {
        let rigid = rigid(transform)?;
        let stamp_ns = stamp_ns(&transform.header)?;
        let now_ns = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |now| now.as_nanos() as u64);
        if self.clock == StampClock::Host && stamp_ns > now_ns + AHEAD_NS {
            let position_m = rigid.translation.vector.into();
            return Err(Fault::Future(Sample {
                stamp_ns,
                position_m,
                velocity_m_s: None,
                acceleration_m_s2: None,
            }));
        }
        let (parent, child) = (name(&transform.header.frame_id), name(&transform.child_frame_id));
        match self.links.state(parent, child, from, Stated { stamp_ns, rigid }) {
            Ok(is_new) => Ok(is_new.then_some(stamp_ns)),
            Err(()) => {
                let what = format!("the transform from {} to {}", plain(parent), plain(child));
                Err(SampleFault::SecondSender(what).into())
            }
        }
    }

    /// Chooses the link that gives the instants: the one that comes most seldom.
    fn choose_leader(&mut self, pair: &FramePair) {
        let Some(chain) = self.links.chain(pair) else { return };
        let moving: Vec<(&str, &Link)> = chain.links().filter(|(_, link)| link.moves()).collect();
        let seldom = |link: &Link| link.interval_ns().unwrap_or(0.0);
        let Some((slowest, link)) =
            moving.iter().max_by(|(_, a), (_, b)| seldom(a).total_cmp(&seldom(b))).copied()
        else {
            return;
        };
        let present = moving.iter().find(|(child, _)| *child == self.leader);
        if present.is_none_or(|(_, present)| seldom(link) > SELDOM * seldom(present)) {
            let stays = slowest == self.leader;
            slowest.clone_into(&mut self.leader);
            if !stays {
                self.pending.clear();
            }
        }
    }

    /// Gives the samples whose links are all there.
    fn give_due(&mut self, pair: &FramePair, give: Give<'_>) {
        let Some(chain) = self.links.chain(pair) else { return };
        self.pending.retain(|stamp_ns| match chain.at(*stamp_ns) {
            Ok(place) => {
                let position_m = place.translation.vector.into();
                give(Ok(Sample {
                    stamp_ns: *stamp_ns,
                    position_m,
                    velocity_m_s: None,
                    acceleration_m_s2: None,
                }));
                false
            }
            Err(missing) => missing == super::links::Missing::NotYet,
        });
    }
}

/// Fault of a link.
enum Fault {
    Sample(SampleFault),
    /// It is of the future: a sample with its stamp.
    Future(Sample),
}

impl From<SampleFault> for Fault {
    fn from(fault: SampleFault) -> Self {
        Self::Sample(fault)
    }
}

fn rigid(transform: &TransformStamped) -> Result<Isometry3<f64>, SampleFault> {
    let translation = vector(transform.translation);
    if !translation.iter().all(|number| number.is_finite()) {
        return Err(SampleFault::Malformed("a number of its translation is not finite".into()));
    }
    Ok(Isometry3::from_parts(translation.into(), rotation(transform.rotation)?))
}

#[cfg(test)]
mod tests;
