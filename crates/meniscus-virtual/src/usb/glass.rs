//! A recorded glass before the simulated USB camera, rendered shot by shot.

use crate::looped_recording::repeated;
use crate::render::{Images, Liquid, Scene, SceneSettings};
use meniscus::surface::Intrinsics;
use meniscus_data::recording::Recording;
use meniscus_hil::device::{
    COLOUR_INTRINSICS, COLOUR_LENS_M, COLOUR_PITCH_RAD, INTRINSICS, INTRINSICS_SMALL, Scenery,
};

/// The glass; behind the recording's end its last frame stays, unless it repeats.
#[derive(Debug)]
pub struct RecordedGlass {
    recording: Recording,
    settings: SceneSettings,
    repeats: bool,
    rests: bool,
    scene: Option<((u16, u16), Scene, Images)>,
    colour: Option<(Scene, Images, Vec<u8>)>,
}

/// Makes the colour image's noise another one.
const COLOUR_SEED: u64 = 0x5955_5932;
/// U and V of every pair of pixels: a warm light.
const TINT: [u8; 2] = [118, 140];

impl RecordedGlass {
    /// A glass under `settings`, whose intrinsics are replaced by the camera's own for the size of its images.
    #[must_use]
    pub fn new(recording: Recording, settings: SceneSettings) -> Self {
        Self { recording, settings, repeats: false, rests: false, scene: None, colour: None }
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

    /// Settings for images of this size (width, height).
    fn sized(&self, size: (u16, u16)) -> SceneSettings {
        let (width, height) = size;
        let [fx, fy, ppx, ppy] = if width == 640 { INTRINSICS } else { INTRINSICS_SMALL };
        let mut settings = self.settings;
        settings.camera.intrinsics =
            Intrinsics { width: width.into(), height: height.into(), fx, fy, ppx, ppy };
        settings
    }
}

impl RecordedGlass {
    /// Settings for colour images: the lens stands and looks where the camera's colour table says, in the light of
    /// the room.
    fn in_colour(&self) -> SceneSettings {
        let [fx, fy, ppx, ppy] = COLOUR_INTRINSICS;
        let mut settings =
            SceneSettings { dots: 0.0, seed: self.settings.seed ^ COLOUR_SEED, ..self.settings };
        let camera = &mut settings.camera;
        camera.intrinsics = Intrinsics { width: 640, height: 480, fx, fy, ppx, ppy };
        let [_, down, forward] = COLOUR_LENS_M;
        let (sin, cos) = camera.camera_pitch_rad.sin_cos();
        camera.camera_height_m += forward * sin - down * cos;
        camera.camera_distance_m -= forward * cos + down * sin;
        camera.camera_pitch_rad += COLOUR_PITCH_RAD;
        settings
    }

    /// The liquid of a shot.
    fn liquid(&self, shot: u64) -> Liquid<'_> {
        let last = self.recording.frames().saturating_sub(1);
        let frame = usize::try_from(shot).unwrap_or(usize::MAX).min(last);
        let frame = if self.rests { 0 } else { frame };
        if self.repeats { repeated(&self.recording, shot) } else { Liquid::of(&self.recording, frame) }
    }

    /// Renders the depth image and the infrared one.
    fn render(&mut self, shot: u64, size: (u16, u16)) {
        let settings = self.sized(size);
        let taken = self.scene.take().filter(|(rendered, ..)| *rendered == size);
        let (_, mut scene, mut images) =
            taken.unwrap_or_else(|| (size, Scene::new(settings), Images::new(&settings)));
        scene.render(&self.liquid(shot), shot, &mut images);
        self.scene = Some((size, scene, images));
    }

    /// Renders the colour image: the infrared one's tones in another place, as luma, of an even tint.
    fn render_colour(&mut self, shot: u64) {
        let settings = self.in_colour();
        let taken = self.colour.take();
        let (mut scene, mut images, mut yuy2) =
            taken.unwrap_or_else(|| (Scene::new(settings), Images::new(&settings), Vec::new()));
        let liquid = self.liquid(shot);
        let [x, y] = liquid.glass_m;
        let beside = Liquid { glass_m: [x - f64::from(COLOUR_LENS_M[0]), y], ..liquid };
        scene.render(&beside, shot, &mut images);
        yuy2.clear();
        yuy2.extend(images.infrared.iter().zip(TINT.iter().cycle()).flat_map(|(luma, tint)| [*luma, *tint]));
        self.colour = Some((scene, images, yuy2));
    }
}

impl Scenery for RecordedGlass {
    fn look(&mut self, shot: u64, size: (u16, u16)) -> (&[u8], &[u8]) {
        self.render(shot, size);
        self.scene.as_ref().map_or((&[], &[]), |(_, _, images)| (&images.depth, &images.infrared))
    }

    fn look_in_colour(&mut self, shot: u64) -> Option<(&[u8], &[u8])> {
        self.render(shot, (640, 480));
        self.render_colour(shot);
        let (_, _, images) = self.scene.as_ref()?;
        let (_, _, yuy2) = self.colour.as_ref()?;
        Some((&images.depth, yuy2))
    }
}
