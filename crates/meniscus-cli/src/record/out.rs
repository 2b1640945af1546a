//! Where recorded images go.

use super::Arguments;
use crate::outline::Outline;
use anyhow::{Context, bail, ensure};
use meniscus::surface::{self, Config, ExtractionState, Liquid, SurfaceProfile, extract};
use meniscus::usb::frame::{DepthFrame, OutlineFrame};
use meniscus::usb::uvc::Stream;
use meniscus_bags::{BagError, Calibration, FolderWriter, Image, McapWriter};
use meniscus_data::profiles::profiles_to_csv;
use meniscus_platform::files::write_whole;
use meniscus_usb::camera::OutlineImage;
use std::path::{Path, PathBuf};

/// Where images go.
pub(super) enum Out {
    Mcap(Box<McapWriter>),
    Folder(Box<FolderWriter>),
    Profiles(Box<Profiles>),
}

/// The profiles of a recording.
pub(super) struct Profiles {
    path: PathBuf,
    config: Config,
    state: ExtractionState,
    depth: Option<Image>,
    profiles: Vec<SurfaceProfile>,
}

impl Out {
    pub(super) fn create(arguments: &Arguments, calibration: &Calibration) -> anyhow::Result<Self> {
        let (path, setup) = (&arguments.out, &arguments.setup);
        let profiles = path.extension().is_some_and(|extension| extension == "csv");
        ensure!(
            profiles || setup.is_none(),
            "--setup is for profiles (--out FILE.csv): images need no glass"
        );
        Ok(match path.extension().and_then(|extension| extension.to_str()) {
            Some("mcap") => Self::Mcap(Box::new(McapWriter::create(path, calibration)?)),
            Some("csv") => {
                let clear = arguments.outline == Some(Outline::Clear);
                let settings = match setup {
                    Some(setup) => crate::glass::read(setup)?.settings(calibration.optics()),
                    None if clear => {
                        surface::Settings::default().of_clear_liquid().with_optics(calibration.optics())
                    }
                    None => surface::Settings::default().with_optics(calibration.optics()),
                };
                ensure!(
                    !clear || settings.liquid == Liquid::Clear,
                    "--outline clear is for a clear liquid, and the setup was made for an opaque one: run \
                     `meniscus setup --outline clear`"
                );
                let config = Config::new(settings).context("the recording's camera cannot see the glass")?;
                let (path, state) = (path.clone(), ExtractionState::new());
                Self::Profiles(Box::new(Profiles { path, config, state, depth: None, profiles: Vec::new() }))
            }
            None => Self::Folder(Box::new(FolderWriter::create(path, calibration)?)),
            Some(other) => bail!("--out ends in .{other}: .mcap, .csv or no ending (a folder) are written"),
        })
    }

    pub(super) fn write(&mut self, image: &Image) -> Result<(), BagError> {
        match self {
            Self::Mcap(writer) => writer.write(image),
            Self::Folder(writer) => writer.write(image),
            Self::Profiles(profiles) => {
                profiles.take(image);
                Ok(())
            }
        }
    }

    /// Ends the output if both streams came; removes it, with an error, if not.
    pub(super) fn finish(self, came: Came, path: &Path) -> anyhow::Result<String> {
        if let Some(missing) = came.missing() {
            self.discard();
            bail!("{missing}: nothing is kept in {}", path.display());
        }
        Ok(match self {
            Self::Mcap(writer) => format!("{} images", writer.finish()?),
            Self::Folder(writer) => format!("{} images", writer.finish()?),
            Self::Profiles(profiles) => {
                write_whole(&profiles.path, profiles_to_csv(&profiles.profiles).as_bytes())?;
                format!("{} profiles", profiles.profiles.len())
            }
        })
    }

    /// Removes what was begun.
    fn discard(self) {
        match self {
            Self::Mcap(writer) => writer.discard(),
            Self::Folder(writer) => writer.discard(),
            Self::Profiles(_) => {}
        }
    }
}

/// Number of images of each stream.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Came {
    pub(super) depth: u64,
    pub(super) outline: u64,
    /// Image that belongs beside the depth.
    pub(super) beside: OutlineImage,
}

impl Came {
    /// Counts an image.
    pub(super) fn count(&mut self, stream: Stream) {
        match stream {
            Stream::Depth => self.depth += 1,
            Stream::Outline => self.outline += 1,
        }
    }

    /// Returns why there is nothing to keep.
    fn missing(&self) -> Option<String> {
        let Self { depth, outline, beside } = *self;
        let other =
            if beside == OutlineImage::Colour { OutlineImage::Infrared } else { OutlineImage::Colour };
        match (depth, outline) {
            (0, 0) => Some("no image came".into()),
            (0, _) => Some(format!("{outline} {beside} images came and no depth image")),
            (_, 0) => Some(format!(
                "{depth} depth images came and no {beside} image, in which the outline is traced (--outline {other} takes the \
                 other one, if it is there)"
            )),
            _ => None,
        }
    }
}

impl Profiles {
    fn take(&mut self, image: &Image) {
        if image.stream == Stream::Depth {
            self.depth = Some(image.clone());
            return;
        }
        let near = |depth: &Image| depth.stamp.captured.0.abs_diff(image.stamp.captured.0) < 8_000;
        let Some(depth) = self.depth.take().filter(near) else { return };
        let (width, height) = self.config.image_size();
        let depth = DepthFrame { bytes: &depth.pixels, width, height, stamp: depth.stamp };
        let infrared = OutlineFrame { bytes: &image.pixels, width, height, stamp: image.stamp };
        self.profiles.extend(extract(&self.config, &mut self.state, depth, infrared).ok());
    }
}
