//! Rendered images of a D435: a glass of opaque liquid on a table before a wall, rendered to Z16 and Y8.
//!
//! Edges are analytic: the coverage of a pixel follows from the outline of the liquid in closed
//! form, so a sub-pixel truth exists. On top come the lens blur, shading, vignetting, the projector's
//! dots and grey noise (infrared); correlated stereo noise, disparity steps, the occlusion band, edge
//! holes and random holes (depth). The same seed and frame number give the same bytes.
//!
//! [`Clutter`] adds foam, a highlight, a finger before the glass, and a liquid that is clear; [`TagPlate`] an AprilTag above the glass,
//! in the infrared image alone.
//!
//! Not modelled: motion blur, refraction by the glass wall, the meniscus that climbs it, the liquid film
//! that a receding surface leaves on it, and that stereo matching smears a step in depth over its window.
//!
//! Only a window around the glass is rendered for each frame, over a cached background; the noise
//! outside of the window is frozen.

mod backdrop;
mod clutter;
mod depth;
mod infrared;
pub(crate) mod noise;
mod outline;
mod sensor;
mod shape;
mod tag;
mod view;

use backdrop::Backdrop;
use clutter::Overlay;
pub use clutter::{Clutter, Finger, Glare};
use meniscus::surface::Settings;
use meniscus_data::glass::WallShape;
use meniscus_data::recording::{Glass, Recording, WALL_POINTS};
use noise::{Noise, mix};
use outline::Outline;
use shape::Shape;
pub(crate) use tag::SQUARES;
pub use tag::{TagPattern, TagPlate};
use view::View;

/// Parts of the scene that change from frame to frame.
#[derive(Clone, Copy)]
struct Subject<'a> {
    /// The glass with its liquid, where it is there.
    outline: Option<&'a Outline>,
    overlay: &'a Overlay,
    /// Position of the glass axis along x, metres.
    axis_m: f64,
}

/// The scene's looks and faults beside the camera's geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneSettings {
    /// Camera, its position, the glass and the liquid's look: those of the reader, unless the
    /// reader's robustness against a wrong calibration is tested.
    pub camera: Settings,
    /// Baseline of the stereo pair, metres.
    pub baseline_m: f64,
    /// Noise of the disparity, pixels rms.
    pub disparity_rms_px: f64,
    /// Share of depth pixels in random holes.
    pub hole_share: f64,
    /// Standard deviation of the lens blur, pixels.
    pub blur_px: f64,
    /// Noise of the infrared image, grey levels rms at mid grey.
    pub grey_rms: f64,
    /// Height of the projector's dots over white, grey levels.
    pub dots: f64,
    /// Share of the room's light that the free surface mirrors towards the camera.
    pub mirror: f64,
    /// Tone of the liquid seen head-on, grey levels; by the liquid's look if not given.
    pub tone: Option<f64>,
    /// Disturbances of the view.
    pub clutter: Clutter,
    /// A tag that moves with the glass.
    pub tag: Option<TagPlate>,
    /// Whether there is a glass with liquid at all.
    pub glass_present: bool,
    /// Seed of everything random.
    pub seed: u64,
}

impl Default for SceneSettings {
    /// A D435 with its usual sub-pixel noise (0.08 px rms), 5 % holes, a projector turned down.
    fn default() -> Self {
        Self {
            camera: Settings::default(),
            baseline_m: 0.050,
            disparity_rms_px: 0.08,
            hole_share: 0.05,
            blur_px: 0.7,
            grey_rms: 2.0,
            dots: 6.0,
            mirror: 0.2,
            tone: None,
            clutter: Clutter::default(),
            tag: None,
            glass_present: true,
            seed: 1,
        }
    }
}

impl SceneSettings {
    /// The usual scene before the glass of a recording.
    #[must_use]
    pub fn of(glass: &Glass) -> Self {
        let camera = Settings::for_glass(glass.radius_m, glass.fill_m, glass.rim_m);
        Self { camera, ..Self::default() }
    }
}

/// The liquid and its glass at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Liquid<'a> {
    /// Position of the glass axis along x and away from the camera, metres.
    pub glass_m: [f64; 2],
    /// Height of the contact line at each of the 72 wall azimuths, metres.
    pub wall_m: &'a [f32],
    /// Height of the surface in each of the 194 lattice columns, metres.
    pub column_m: &'a [f32],
}

impl<'a> Liquid<'a> {
    /// The liquid in `frame` of a recording.
    ///
    /// # Panics
    /// When there is no such frame.
    #[must_use]
    pub fn of(recording: &'a Recording, frame: usize) -> Self {
        let columns = recording.column_m.len() / recording.frames();
        Self {
            glass_m: [recording.glass_x_m[frame], recording.glass_y_m[frame]],
            wall_m: &recording.wall_m[frame * WALL_POINTS..(frame + 1) * WALL_POINTS],
            column_m: &recording.column_m[frame * columns..(frame + 1) * columns],
        }
    }
}

/// A pair of images, as bytes on the wire.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Images {
    /// Z16, little-endian.
    pub depth: Vec<u8>,
    /// Y8.
    pub infrared: Vec<u8>,
}

impl Images {
    /// Black images without depth, of the size that the settings state.
    #[must_use]
    pub fn new(settings: &SceneSettings) -> Self {
        let pixels = settings.camera.intrinsics.width * settings.camera.intrinsics.height;
        Self { depth: vec![0; 2 * pixels], infrared: vec![0; pixels] }
    }
}

/// A rectangle of pixels, ends exclusive.
#[derive(Clone, Copy, Debug)]
struct Window {
    left: usize,
    right: usize,
    top: usize,
    bottom: usize,
}

impl Window {
    fn width(&self) -> usize {
        self.right - self.left
    }

    fn height(&self) -> usize {
        self.bottom - self.top
    }
}

/// The renderer with its cached background.
#[derive(Clone, Debug)]
pub struct Scene {
    settings: SceneSettings,
    view: View,
    window: Window,
    shape: Shape,
    backdrop: Backdrop,
    noise: Noise,
    infrared: infrared::Painter,
    depth: depth::Painter,
}

impl Scene {
    /// Renders the background once.
    ///
    /// # Panics
    /// When the image is too small to hold the glass.
    #[must_use]
    pub fn new(settings: SceneSettings) -> Self {
        let view = View::new(&settings);
        let camera = &settings.camera;
        let glass = Glass {
            radius_m: f64::from(camera.radius_m),
            fill_m: f64::from(camera.fill_m),
            rim_m: f64::from(camera.rim_m),
            wall: WallShape::UPRIGHT,
        };
        let top_m = settings.tag.map_or(glass.rim_m, |tag| tag.top_m().max(glass.rim_m));
        let window = view.window(&glass, top_m);
        let noise = Noise::new(settings.seed);
        let backdrop = Backdrop::new(&settings, &view, &noise);
        Self {
            view,
            window,
            shape: Shape::new(&glass),
            backdrop,
            noise,
            infrared: infrared::Painter::new(window, settings.blur_px),
            depth: depth::Painter::new(window),
            settings,
        }
    }

    /// Takes other clutter from the next frame on.
    pub fn disturb(&mut self, clutter: Clutter) {
        self.settings.clutter = clutter;
    }

    /// Renders one frame; `frame` seeds its noise.
    ///
    /// # Panics
    /// When the liquid has not 72 wall heights and 194 column heights, or `out` another size.
    pub fn render(&mut self, liquid: &Liquid<'_>, frame: u64, out: &mut Images) {
        out.infrared.copy_from_slice(&self.backdrop.infrared);
        out.depth.copy_from_slice(&self.backdrop.depth);
        self.shape.set(liquid.wall_m, liquid.column_m);
        let [axis_m, away_m] = liquid.glass_m;
        let view = self.view.farther(away_m);
        let outline = self
            .settings
            .glass_present
            .then(|| Outline::new(&view, &self.settings, &self.shape, axis_m, self.window));
        let seed = mix(self.settings.seed ^ mix(frame));
        let (settings, backdrop, noise) = (&self.settings, &self.backdrop, &self.noise);
        let radius_m = settings.camera.radius_m.into();
        let overlay = Overlay::new(&view, settings.clutter, axis_m, radius_m, seed);
        let subject = Subject { outline: outline.as_ref(), overlay: &overlay, axis_m };
        self.infrared.paint(settings, &view, backdrop, subject, noise, seed, &mut out.infrared);
        self.depth.paint(settings, &view, backdrop, subject, noise, seed, &mut out.depth);
    }
}
