//! Topics of a recording, and which of them are the camera's.
//!
//! Depth images are known by their encoding, the image of the outline by its encoding and size, the camera's numbers by a name
//! beside that of the depth images. Where several are left, a person has to choose.

use super::RosChoice;
use super::messages::{FLOAT_UNIT_M, Fault, ImageMessage, Info, Pixel};
use super::source::Topic;
use crate::Calibration;
use meniscus::usb::uvc::Stream;
use meniscus_usb::camera::OutlineImage;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Metres in one unit of integer depth images, by REP 118.
const INTEGER_UNIT_M: f32 = 0.001;

/// Topics at most.
const MOST: usize = 4096;

/// Coefficient of distortion that matters.
const DISTORTED: f64 = 1e-6;

/// Topics with the first message of each.
#[derive(Debug, Default)]
pub(super) struct Found {
    topics: BTreeMap<u32, Topic>,
    images: BTreeMap<u32, First>,
    infos: BTreeMap<u32, Info>,
}

/// First image of a topic.
#[derive(Clone, Debug)]
struct First {
    encoding: String,
    size: (u32, u32),
}

/// Topics that are read, and their camera.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    depth: u32,
    outline: u32,
    pub(super) calibration: Calibration,
}

impl Chosen {
    /// Returns the stream that the topic `id` carries.
    pub(super) fn stream(&self, id: u32) -> Option<Stream> {
        match id {
            id if id == self.depth => Some(Stream::Depth),
            id if id == self.outline => Some(Stream::Outline),
            _ => None,
        }
    }
}

fn is_image(topic: &Topic) -> bool {
    matches!(topic.kind.as_str(), "sensor_msgs/Image" | "sensor_msgs/msg/Image")
}

fn is_info(topic: &Topic) -> bool {
    matches!(topic.kind.as_str(), "sensor_msgs/CameraInfo" | "sensor_msgs/msg/CameraInfo")
}

impl Found {
    /// Adds a topic.
    pub(super) fn add(&mut self, topic: Topic) {
        if self.topics.len() < MOST {
            self.topics.insert(topic.id, topic);
        }
    }

    /// Looks at a message; returns whether it is an image.
    pub(super) fn look(&mut self, id: u32, data: &[u8]) -> Result<bool, Fault> {
        let Some(topic) = self.topics.get(&id) else { return Ok(false) };
        if is_info(topic) && !self.infos.contains_key(&id) {
            self.infos.insert(id, Info::read(data, topic.aligned)?);
        }
        if !is_image(topic) {
            return Ok(false);
        }
        if let Entry::Vacant(first) = self.images.entry(id) {
            let message = ImageMessage::read(data, topic.aligned)?;
            first.insert(First { encoding: message.encoding.into(), size: message.size });
        }
        Ok(true)
    }

    /// Returns which topics have aligned messages.
    pub(super) fn aligned(&self) -> BTreeMap<u32, bool> {
        self.topics.values().map(|topic| (topic.id, topic.aligned)).collect()
    }

    /// Chooses the camera's topics.
    pub(super) fn choose(&self, choice: &RosChoice) -> Result<Chosen, String> {
        let depth = self.depth(choice)?;
        let first = &self.images[&depth];
        let (outline, image) = self.outline(choice, first.size)?;
        let mut calibration = match &choice.camera {
            Some(camera) => camera.clone(),
            None => self.camera(choice, depth)?,
        };
        if calibration.size != first.size {
            let ((w, h), (width, height)) = (calibration.size, first.size);
            return Err(format!(
                "its camera has {w} x {h} pixels, and its depth images have {width} x {height}"
            ));
        }
        calibration.depth_unit_m = match (Pixel::of(&first.encoding), choice.depth_unit_m, &choice.camera) {
            (Some(Pixel::DepthFloat), ..) => FLOAT_UNIT_M,
            (_, Some(unit_m), _) => unit_m,
            (_, None, Some(camera)) => camera.depth_unit_m,
            (_, None, None) => INTEGER_UNIT_M,
        };
        calibration.outline = image;
        Ok(Chosen { depth, outline, calibration })
    }

    /// Returns the chosen topics for a log.
    pub(super) fn said(&self, chosen: &Chosen) -> String {
        format!("depth from {}, outline from {}", self.name(chosen.depth), self.name(chosen.outline))
    }

    fn name(&self, id: u32) -> &str {
        self.topics.get(&id).map_or("", |topic| topic.name.as_str())
    }

    /// Returns the topics of images and cameras for people.
    fn listed(&self) -> String {
        let image = |topic: &Topic| {
            self.images.get(&topic.id).map_or_else(
                || "no image in the first part".into(),
                |first| format!("{} {} x {}", first.encoding, first.size.0, first.size.1),
            )
        };
        let one = |topic: &Topic| match (is_image(topic), is_info(topic)) {
            (true, _) => Some(format!("{} ({})", topic.name, image(topic))),
            (_, true) => Some(format!("{} (camera info)", topic.name)),
            _ if topic.kind.ends_with("/CompressedImage") => {
                Some(format!("{} (compressed, which is not read)", topic.name))
            }
            _ => None,
        };
        let all: Vec<String> = self.topics.values().filter_map(one).take(20).collect();
        if all.is_empty() { "no images".into() } else { all.join(", ") }
    }

    /// Returns the image topic called `name`.
    fn called(&self, name: &str, flag: &str) -> Result<u32, String> {
        let found = self.images.keys().find(|id| self.name(**id) == name).copied();
        found.ok_or_else(|| format!("{flag} {name} has no images in it; it has {}", self.listed()))
    }

    /// Returns the only one of `candidates`, or the only one that `prefers` a name.
    fn only(&self, candidates: Vec<u32>, prefers: &dyn Fn(&str) -> bool) -> Result<Option<u32>, Vec<u32>> {
        if candidates.len() < 2 {
            return Ok(candidates.first().copied());
        }
        let preferred: Vec<u32> = candidates.iter().filter(|id| prefers(self.name(**id))).copied().collect();
        if preferred.len() == 1 { Ok(preferred.first().copied()) } else { Err(candidates) }
    }

    fn depth(&self, choice: &RosChoice) -> Result<u32, String> {
        let is_depth =
            |first: &First| matches!(Pixel::of(&first.encoding), Some(Pixel::Depth16 | Pixel::DepthFloat));
        if let Some(name) = &choice.depth_topic {
            let id = self.called(name, "--depth-topic")?;
            let encoding = &self.images[&id].encoding;
            return if is_depth(&self.images[&id]) {
                Ok(id)
            } else {
                Err(format!(
                    "--depth-topic {name} has images of encoding {encoding}: depth is 16UC1 or 32FC1"
                ))
            };
        }
        let candidates = self.images.iter().filter(|(_, first)| is_depth(first)).map(|(id, _)| *id).collect();
        let plain =
            |name: &str| name.contains("depth") && !name.contains("aligned") && !name.contains("registered");
        match self.only(candidates, &plain) {
            Ok(Some(id)) => Ok(id),
            Ok(None) => Err(format!("it has no depth images (16UC1 or 32FC1); it has {}", self.listed())),
            Err(several) => Err(format!(
                "{} could be its depth images: choose one with --depth-topic",
                self.names(&several)
            )),
        }
    }

    fn names(&self, ids: &[u32]) -> String {
        ids.iter().map(|id| self.name(*id)).collect::<Vec<_>>().join(" and ")
    }

    /// Returns the topic of the image beside the depth, and which one it is.
    fn outline(&self, choice: &RosChoice, size: (u32, u32)) -> Result<(u32, OutlineImage), String> {
        let (width, height) = size;
        let kind = |id: u32| Pixel::of(&self.images[&id].encoding);
        let image = |id: u32| match kind(id) {
            Some(Pixel::Colour(..)) => OutlineImage::Colour,
            _ => OutlineImage::Infrared,
        };
        if let Some(name) = &choice.outline_topic {
            let id = self.called(name, "--outline-topic")?;
            let First { encoding, size: (w, h) } = &self.images[&id];
            return match kind(id) {
                Some(Pixel::Grey | Pixel::Colour(..)) if (*w, *h) == size => Ok((id, image(id))),
                Some(Pixel::Grey | Pixel::Colour(..)) => Err(format!(
                    "--outline-topic {name} has images of {w} x {h} pixels, and the depth images have {width} x {height}: both must \
                     be of one lens (infrared, or depth aligned to colour)"
                )),
                _ => Err(format!(
                    "--outline-topic {name} has images of encoding {encoding}: mono8, 8UC1, rgb8, bgr8, rgba8 or bgra8 are read"
                )),
            };
        }
        let of_size = |id: &u32| self.images[id].size == size;
        let grey = |id: &u32| kind(*id) == Some(Pixel::Grey);
        let candidates = self.images.keys().filter(|id| of_size(id) && grey(id)).copied().collect();
        let left = |name: &str| name.contains("infra1") || name.contains("left");
        match self.only(candidates, &left) {
            Ok(Some(id)) => Ok((id, image(id))),
            Ok(None) => Err(format!(
                "it has no grey images (mono8 or 8UC1) of {width} x {height} pixels, as its depth images have, in which the outline of \
                 the glass could be traced: give --outline-topic where depth is aligned to colour; it has {}",
                self.listed()
            )),
            Err(several) => Err(format!(
                "{} could be the image of the outline: choose one with --outline-topic",
                self.names(&several)
            )),
        }
    }

    /// Returns the camera of the depth topic.
    fn camera(&self, choice: &RosChoice, depth: u32) -> Result<Calibration, String> {
        let name = self.name(depth);
        let what_to_give = "give --info-topic, or the camera as --camera-file camera.json (docs/formats.md)";
        let info = match &choice.info_topic {
            Some(wanted) => {
                let found = self.infos.iter().find(|(id, _)| self.name(**id) == wanted).map(|(_, info)| info);
                found.ok_or_else(|| {
                    format!("--info-topic {wanted} has no camera info in it; it has {}", self.listed())
                })?
            }
            None => {
                let folder = name.rsplit_once('/').map_or("", |(folder, _)| folder);
                let beside = [format!("{folder}/camera_info"), format!("{name}/camera_info")];
                let near =
                    self.infos.iter().find(|(id, _)| beside.iter().any(|beside| beside == self.name(**id)));
                let only = self.infos.iter().next().filter(|_| self.infos.len() == 1);
                let info = near.or(only).map(|(_, info)| info);
                info.ok_or_else(|| match self.infos.len() {
                    0 => format!("it has no camera info for {name}: {what_to_give}"),
                    _ => format!(
                        "no camera info stands beside {name}: {what_to_give}; it has {}",
                        self.listed()
                    ),
                })?
            }
        };
        calibration(info, name)
    }
}

/// Returns the camera of `info`, whose depth images are those of the topic `name`.
fn calibration(info: &Info, name: &str) -> Result<Calibration, String> {
    let rectified = name.contains("rect");
    if let Some(worst) = info.distortion.iter().find(|d| d.abs() > DISTORTED || !d.is_finite())
        && !rectified
    {
        return Err(format!(
            "the images of {name} are distorted (a coefficient of {worst}): rectify them with image_proc, or record the rectified \
             topic"
        ));
    }
    let [fx, fy, cx, cy] = match info.p {
        p if rectified && p[0] > 0.0 => [p[0], p[5], p[2], p[6]],
        _ => [info.k[0], info.k[4], info.k[2], info.k[5]],
    };
    Ok(Calibration {
        size: info.size,
        focal_px: [fx as f32, fy as f32],
        centre_px: [cx as f32, cy as f32],
        depth_unit_m: INTEGER_UNIT_M,
        baseline_m: 0.0,
        camera: format!("ROS topic {name}"),
        outline: OutlineImage::Infrared,
        depth_lens_m: [0.0; 3],
    })
}
