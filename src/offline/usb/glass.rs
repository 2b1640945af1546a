//! A recorded glass before the simulated USB camera, rendered shot by shot.

use crate::offline::prelude::*;
use crate::offline::recording::Recording;
use crate::offline::repeat::repeated;
use crate::offline::scene::{Images, Liquid, Scene, SceneSettings};
use crate::surface::Intrinsics;
use meniscus_hil::device::{INTRINSICS, INTRINSICS_SMALL, Scenery};

/// The glass; behind the recording's end its last frame stays, unless it repeats.
#[derive(Debug)]
pub struct RecordedGlass {
    recording: Recording,
    settings: SceneSettings,
    repeats: bool,
    rests: bool,
    scene: Option<((u16, u16), Scene, Images)>,
}

impl RecordedGlass {
    /// A glass under `settings`, whose intrinsics are replaced by the camera's own for the size of its images.
    #[must_use]
    pub fn new(recording: Recording, settings: SceneSettings) -> Self {
        Self { recording, settings, repeats: false, rests: false, scene: None }
    }

    /// The same glass, for which the recording begins again where it ends ([`repeated`]).
    #[must_use]
    pub fn repeating(self, repeats: bool) -> Self {
        Self { repeats, ..self }
    }

    /// The same glass, which stays as the recording begins: at rest.
    #[must_use]
    pub fn resting(self) -> Self {
        Self { rests: true, ..self }
    }

    /// Settings for images of this size.
    fn sized(&self, (width, height): (u16, u16)) -> SceneSettings {
        let [fx, fy, ppx, ppy] = if width == 640 { INTRINSICS } else { INTRINSICS_SMALL };
        let mut settings = self.settings;
        settings.camera.intrinsics =
            Intrinsics { width: width.into(), height: height.into(), fx, fy, ppx, ppy };
        settings
    }
}

impl Scenery for RecordedGlass {
    fn look(&mut self, shot: u64, size: (u16, u16)) -> (&[u8], &[u8]) {
        let (settings, recording) = (self.sized(size), &self.recording);
        if self.scene.as_ref().is_none_or(|(rendered, ..)| *rendered != size) {
            self.scene = None;
        }
        let (_, scene, images) =
            self.scene.get_or_insert_with(|| (size, Scene::new(settings), Images::new(&settings)));
        let frame = usize::try_from(shot).unwrap_or(usize::MAX).min(recording.frames().saturating_sub(1));
        let frame = if self.rests { 0 } else { frame };
        let liquid = if self.repeats { repeated(recording, shot) } else { Liquid::of(recording, frame) };
        scene.render(&liquid, shot, images);
        (&images.depth, &images.infrared)
    }
}
