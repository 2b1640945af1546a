//! Links of the tree of frames, each with its newest transforms.

use super::FramePair;
use super::rotation::between;
use meniscus_service::commanded_motion::SenderId;
use nalgebra::Isometry3;
use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

/// Transforms of a link that are kept: a quarter of a second at 250 Hz.
const KEPT: usize = 64;

/// Frames at the most, and links of a chain: a tree that is larger, or goes in a circle, is none of a robot.
const FRAMES_MOST: usize = 1024;
const CHAIN_MOST: usize = 64;

/// Silence after which another publisher may state a link.
const SILENCE: Duration = Duration::from_secs(1);

/// A transform at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stated {
    pub(super) stamp_ns: u64,
    pub(super) rigid: Isometry3<f64>,
}

/// Reason for which a link has no transform at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Missing {
    /// It may still come.
    NotYet,
    /// The instant is before the first one.
    Gone,
}

/// Link of a frame to its parent.
#[derive(Debug)]
pub(super) struct Link {
    parent: String,
    /// Transforms by their stamps; one alone where the link is fixed.
    stated: VecDeque<Stated>,
    /// Publisher, and when it was heard; `None` of a fixed link.
    publisher: Option<(SenderId, Instant)>,
}

impl Link {
    /// Whether it is stated again and again.
    pub(super) fn moves(&self) -> bool {
        self.publisher.is_some()
    }

    /// Whether a publisher other than `from` has stated it just now.
    fn is_held(&self, from: Option<SenderId>) -> bool {
        self.publisher.is_some_and(|(publisher, heard)| Some(publisher) != from && heard.elapsed() < SILENCE)
    }

    /// Returns the mean time between two transforms, ns.
    pub(super) fn interval_ns(&self) -> Option<f64> {
        let (first, last) = (self.stated.front()?, self.stated.back()?);
        let intervals = self.stated.len().checked_sub(1).filter(|count| *count > 0)?;
        Some((last.stamp_ns - first.stamp_ns) as f64 / intervals as f64)
    }

    fn at(&self, stamp_ns: u64) -> Result<Isometry3<f64>, Missing> {
        let after = self.stated.partition_point(|stated| stated.stamp_ns < stamp_ns);
        let next = self.stated.get(after);
        if !self.moves() {
            return self.stated.front().map(|stated| stated.rigid).ok_or(Missing::NotYet);
        }
        let next = next.ok_or(Missing::NotYet)?;
        if next.stamp_ns == stamp_ns {
            return Ok(next.rigid);
        }
        let last = after.checked_sub(1).and_then(|before| self.stated.get(before)).ok_or(Missing::Gone)?;
        let share = (stamp_ns - last.stamp_ns) as f64 / (next.stamp_ns - last.stamp_ns) as f64;
        Ok(between(&last.rigid, &next.rigid, share))
    }
}

/// All links, by the child frame.
#[derive(Debug, Default)]
pub(super) struct Links(BTreeMap<String, Link>);

/// Links between two frames, below the frame that is above both.
pub(super) struct Chain<'l> {
    /// From the parent frame upwards.
    from: Vec<(&'l str, &'l Link)>,
    /// From the child frame upwards.
    to: Vec<(&'l str, &'l Link)>,
}

impl<'l> Chain<'l> {
    /// Returns the links with their child frames.
    pub(super) fn links(&self) -> impl Iterator<Item = (&'l str, &'l Link)> {
        self.from.iter().chain(&self.to).copied()
    }

    /// Whether `child` is a child frame of one of its links.
    pub(super) fn has(&self, child: &str) -> bool {
        self.links().any(|(of, _)| of == child)
    }

    /// Returns the place of the child frame in the parent frame.
    pub(super) fn at(&self, stamp_ns: u64) -> Result<Isometry3<f64>, Missing> {
        let below = |links: &[(&str, &Link)]| {
            let mut from_above = links.iter().rev();
            from_above.try_fold(Isometry3::identity(), |place, (_, link)| Ok(place * link.at(stamp_ns)?))
        };
        Ok(below(&self.from)?.inv_mul(&below(&self.to)?))
    }
}

impl Links {
    /// Returns the names of the frames.
    pub(super) fn frames(&self) -> Vec<&str> {
        let both = self.0.iter().flat_map(|(child, link)| [child.as_str(), link.parent.as_str()]);
        let mut frames: Vec<&str> = both.collect();
        frames.sort_unstable();
        frames.dedup();
        frames
    }

    /// Takes a fixed link, unless a publisher states it again and again.
    pub(super) fn fix(&mut self, parent: &str, child: &str, rigid: Isometry3<f64>) {
        if self.0.get(child).is_some_and(|link| link.is_held(None)) {
            return;
        }
        if let Some(link) = self.link(parent, child) {
            link.publisher = None;
            link.stated.clear();
            link.stated.push_back(Stated { stamp_ns: 0, rigid });
        }
    }

    /// Takes a transform of `from`; returns whether it is new, or an error where another publisher has the link.
    pub(super) fn state(
        &mut self,
        parent: &str,
        child: &str,
        from: SenderId,
        stated: Stated,
    ) -> Result<bool, ()> {
        if self.0.get(child).is_some_and(|link| link.is_held(Some(from))) {
            return Err(());
        }
        let Some(link) = self.link(parent, child) else { return Ok(false) };
        if link.publisher.is_none_or(|(publisher, _)| publisher != from) {
            // Fixed so far, or of another publisher.
            link.stated.clear();
        }
        link.publisher = Some((from, Instant::now()));
        let place = link.stated.partition_point(|kept| kept.stamp_ns < stated.stamp_ns);
        if link.stated.get(place).is_some_and(|kept| kept.stamp_ns == stated.stamp_ns) {
            return Ok(false);
        }
        link.stated.insert(place, stated);
        if link.stated.len() > KEPT {
            link.stated.pop_front();
        }
        Ok(true)
    }

    /// Returns the link of `child`, which has `parent` from now on; `None` where there is no room.
    fn link(&mut self, parent: &str, child: &str) -> Option<&mut Link> {
        if !self.0.contains_key(child) && self.0.len() >= FRAMES_MOST {
            return None;
        }
        let new = || Link { parent: parent.into(), stated: VecDeque::new(), publisher: None };
        let link = self.0.entry(child.into()).or_insert_with(new);
        if link.parent != parent {
            *link = new();
        }
        Some(link)
    }

    /// Returns the links between the frames of `pair`; `None` where they are not joined.
    pub(super) fn chain(&self, pair: &FramePair) -> Option<Chain<'_>> {
        let (mut from, mut to) = (self.above(&pair.parent)?, self.above(&pair.child)?);
        let top = |links: &[(&str, &Link)], frame: &str| {
            links.last().map_or(frame.to_owned(), |(_, link)| link.parent.clone())
        };
        if top(&from, &pair.parent) != top(&to, &pair.child) {
            return None;
        }
        // Links above the frame that is above both.
        while let (Some((a, _)), Some((b, _))) = (from.last(), to.last())
            && a == b
        {
            from.pop();
            to.pop();
        }
        Some(Chain { from, to })
    }

    /// Returns the links from `frame` upwards; `None` where they go in a circle.
    fn above<'l>(&'l self, frame: &str) -> Option<Vec<(&'l str, &'l Link)>> {
        let (mut links, mut frame) = (Vec::new(), frame);
        while let Some((child, link)) = self.0.get_key_value(frame) {
            if links.len() == CHAIN_MOST {
                return None;
            }
            links.push((child.as_str(), link));
            frame = &link.parent;
        }
        Some(links)
    }
}
