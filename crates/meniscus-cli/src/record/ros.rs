//! Topics of a recording of another program, as a person chooses them.

use anyhow::{Context, bail};
use meniscus_bags::{Calibration, RosChoice};
use std::path::PathBuf;

/// Topics of a ROS bag, where it does not say which are the camera's.
#[derive(clap::Args)]
pub(super) struct Topics {
    /// Topic of the depth images of a ROS bag, where it has several.
    #[arg(long, value_name = "TOPIC", help_heading = "ROS bags of other programs")]
    depth_topic: Option<String>,
    /// Topic of the images in which the glass's outline is traced; by default the left infrared one.
    ///
    /// Its images have the size and the lens of the depth images: infrared, or colour where depth is aligned to it.
    #[arg(long, value_name = "TOPIC", help_heading = "ROS bags of other programs")]
    outline_topic: Option<String>,
    /// Topic of the camera info of the depth images; by default the one beside them.
    #[arg(
        long,
        value_name = "TOPIC",
        conflicts_with = "camera_file",
        help_heading = "ROS bags of other programs"
    )]
    info_topic: Option<String>,
    /// Camera of a bag without camera info, in the form of camera.json.
    #[arg(long, value_name = "FILE.json", help_heading = "ROS bags of other programs")]
    camera_file: Option<PathBuf>,
    /// Length of one unit of integer depth images, mm [default: 1, or that of --camera-file].
    #[arg(long, value_name = "MM", value_parser = unit, help_heading = "ROS bags of other programs")]
    depth_unit_mm: Option<f32>,
}

/// Least and largest unit of depth, mm.
const UNITS_MM: (f32, f32) = (0.001, 10.0);

fn unit(text: &str) -> Result<f32, String> {
    let (least, largest) = UNITS_MM;
    let unit_mm = text.parse::<f32>().ok().filter(|unit_mm| (least..=largest).contains(unit_mm));
    unit_mm.ok_or_else(|| format!("'{text}' is no unit from {least} to {largest} mm"))
}

impl Topics {
    /// Refuses them beside `source`, which is a camera.
    pub(super) fn refuse(&self, source: &str) -> anyhow::Result<()> {
        let given = [
            ("--depth-topic", self.depth_topic.is_some()),
            ("--outline-topic", self.outline_topic.is_some()),
            ("--info-topic", self.info_topic.is_some()),
            ("--camera-file", self.camera_file.is_some()),
            ("--depth-unit-mm", self.depth_unit_mm.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((flag, _)) => {
                bail!("{flag} is of ROS bags, and --source {source} is a camera: leave it out")
            }
            None => Ok(()),
        }
    }

    /// Returns the choice; the camera's file is read.
    pub(super) fn choice(&self) -> anyhow::Result<RosChoice> {
        let camera = match &self.camera_file {
            Some(path) => Some(Calibration::read(path).with_context(|| {
                format!("{} is not the camera of docs/formats.md (camera.json)", path.display())
            })?),
            None => None,
        };
        Ok(RosChoice {
            depth_topic: self.depth_topic.clone(),
            outline_topic: self.outline_topic.clone(),
            info_topic: self.info_topic.clone(),
            depth_unit_m: self.depth_unit_mm.map(|unit_mm| 1e-3 * unit_mm),
            camera,
        })
    }
}
