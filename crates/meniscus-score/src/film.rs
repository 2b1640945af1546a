//! A film of a run beside the truth: the camera's image with both surfaces, a slice of the estimated and the true
//! liquid, before a correction and after it, and the error as time goes on (the paper's figures 6 to 8, moving).

use super::baseline::linear_with_motion;
use super::score::{Score, field_of, score};
use meniscus::blob::Model;
use meniscus::surface::{Config, ConfigError};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::{Lattice, Recording, STATE};
use meniscus_data::validity::Validity;
use meniscus_report::plot::PictureError;
use meniscus_service::timed_turn::TimedTurn;
use meniscus_ui::figure_parts::{camera, slice};
use meniscus_ui::picture::{Curve, Picture};
use meniscus_virtual::camera::START;
use meniscus_virtual::observe_recording::{sightings, turns};
use meniscus_virtual::render::{Images, Liquid, Scene, SceneSettings};

/// Width and height of a film, pixels.
pub const SIZE: (u32, u32) = (1200, 760);

/// Why there is no film.
#[derive(Debug)]
pub enum FilmError {
    /// The glass or the camera cannot be.
    Camera(ConfigError),
    /// It cannot be drawn or written down.
    Picture(PictureError),
}

impl std::fmt::Display for FilmError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Camera(error) => write!(f, "the camera cannot look at this glass: {error}"),
            Self::Picture(error) => write!(f, "{error}"),
        }
    }
}

impl std::error::Error for FilmError {}

impl From<PictureError> for FilmError {
    fn from(error: PictureError) -> Self {
        Self::Picture(error)
    }
}

/// A model at its work on the recording.
struct Watched<'m> {
    name: &'m str,
    model: &'m Model<'m>,
    turns: Vec<TimedTurn>,
    score: Score,
}

/// A recording as models saw it through the simulated camera.
pub struct Film<'r, 'm> {
    recording: &'r Recording,
    config: Config,
    scene: Scene,
    images: Images,
    lattice: Lattice,
    watched: Vec<Watched<'m>>,
    top: f64,
}

impl<'r, 'm> Film<'r, 'm> {
    /// Lets every model of `models`, each with its name, watch `recording` under `settings`; the first frames have no
    /// estimate.
    ///
    /// # Errors
    /// [`FilmError::Camera`].
    pub fn new(
        recording: &'r Recording,
        settings: SceneSettings,
        models: &[(&'m str, &'m Model<'m>)],
    ) -> Result<Self, FilmError> {
        let config = Config::new(settings.camera).map_err(FilmError::Camera)?;
        let seen = sightings(recording, settings).map_err(FilmError::Camera)?;
        let linear = linear_with_motion(recording);
        let watch = |&(name, model): &(&'m str, &'m Model<'m>)| {
            let turns = turns(model, &seen);
            let score = score(model, recording, &linear, &turns, START);
            Watched { name, model, turns, score }
        };
        let watched = models.iter().map(watch).collect();
        let lattice = Lattice::new(&recording.glass);
        let mut state = vec![0.0; STATE];
        let mut fastest = |frame: usize| {
            recording.state(frame, &mut state);
            slice(&lattice, recording, recording.known, &state).values().fold(0.0, f64::max)
        };
        let top = (0..recording.frames()).step_by(6).map(&mut fastest).fold(0.0, f64::max);
        let images = Images::new(&settings);
        Ok(Self { recording, config, scene: Scene::new(settings), images, lattice, watched, top })
    }

    /// Frames of the recording.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.recording.frames()
    }

    /// The frame with the highest crest.
    #[must_use]
    pub fn crest(&self) -> usize {
        let fill_m = self.recording.glass.fill_m as f32;
        let crest = |frame: usize| {
            self.recording.profile(frame).iter().map(|z| (z - fill_m).abs()).fold(0.0, f32::max)
        };
        (0..self.frames()).max_by(|&a, &b| crest(a).total_cmp(&crest(b))).unwrap_or(0)
    }

    /// The picture of `frame`, as red, green and blue, row after row.
    ///
    /// # Errors
    /// [`FilmError::Picture`].
    pub fn frame(&mut self, frame: usize, size: (u32, u32)) -> Result<Vec<u8>, FilmError> {
        self.scene.render(&Liquid::of(self.recording, frame), frame as u64, &mut self.images);
        let seconds = frame as f64 * FRAME_INTERVAL_S;
        let mut state = vec![0.0; STATE];
        let mut slices = Vec::new();
        for watched in &self.watched {
            field_of(watched.model, &watched.turns[frame].turn.estimate, &mut state);
            let known = watched.model.header.known();
            slices.push((String::from(watched.name), slice(&self.lattice, self.recording, known, &state)));
        }
        self.recording.state(frame, &mut state);
        slices.push(("true".into(), slice(&self.lattice, self.recording, self.recording.known, &state)));
        // The camera's panel shows the last model: the corrected one, where there is one.
        let Some(last) = self.watched.last() else { return Ok(Vec::new()) };
        let turn = &last.turns[frame].turn;
        let curve = |watched: &Watched<'_>| Curve {
            name: format!(
                "{}: {:.1} % relative to the slosh",
                watched.name,
                100.0 * watched.score.estimate.slosh_rel()
            ),
            points: watched.score.curves[0].clone(),
        };
        let picture = Picture {
            title: format!(
                "{} at {seconds:.2} s: estimates beside the truth",
                self.recording.provenance.liquid
            ),
            camera: camera(&self.config, self.recording, &self.images.infrared, turn, frame),
            slices,
            value: "speed, m/s".into(),
            unknown: self.watched.iter().find_map(|watched| Validity::of(&watched.model.header).sentence),
            top: Some(self.top),
            // The last is what matters: it comes first, in the colour of our own.
            errors: self.watched.iter().rev().map(curve).collect(),
            now_s: Some(seconds),
            glass_mm: (1e3 * self.recording.glass.radius_m, 1e3 * self.recording.glass.rim_m),
            letters: 1.15,
        };
        Ok(picture.rgb(size)?)
    }
}

/// Frames of a film.
#[derive(Clone, Copy, Debug)]
pub struct Reel {
    /// Number of frames.
    pub count: usize,
    /// Frames a second.
    pub rate: u16,
    /// Width of the film, pixels.
    pub width: u32,
    /// Frame that a viewer shows that cannot play films.
    pub still: usize,
}

/// The frames of `reel`, each of [`SIZE`] from `frame`, as one animated PNG that repeats.
///
/// # Errors
/// [`FilmError`], of a frame or of the file.
pub fn animation(
    reel: Reel,
    mut frame: impl FnMut(usize) -> Result<Vec<u8>, FilmError>,
) -> Result<Vec<u8>, FilmError> {
    let Reel { count, rate, width, still } = reel;
    let mut bytes = Vec::new();
    let height = (SIZE.1 * width).div_ceil(SIZE.0);
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.set_animated(u32::try_from(count).unwrap_or(u32::MAX), 0).map_err(wrong)?;
    encoder.set_frame_delay(1, rate).map_err(wrong)?;
    // The still is no frame of the film: whoever plays it never sees it.
    encoder.set_sep_def_img(true).map_err(wrong)?;
    let mut writer = encoder.write_header().map_err(wrong)?;
    for k in std::iter::once(still).chain(0..count) {
        let pixels = frame(k)?;
        let small = if (width, height) == SIZE { pixels } else { scaled(pixels, (width, height)) };
        writer.write_image_data(&small).map_err(wrong)?;
    }
    writer.finish().map_err(wrong)?;
    Ok(bytes)
}

/// `pixels` of [`SIZE`] as a PNG.
///
/// # Errors
/// [`FilmError::Picture`].
pub fn still(pixels: &[u8]) -> Result<Vec<u8>, FilmError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, SIZE.0, SIZE.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(wrong)?;
    writer.write_image_data(pixels).map_err(wrong)?;
    writer.finish().map_err(wrong)?;
    Ok(bytes)
}

/// Step between the grey levels of a smaller film: most of a film's bytes are the camera's noise.
const LEVEL: u16 = 17;

/// An RGB picture of [`SIZE`] as one of `size`, without jagged edges and in 16 levels of each colour.
fn scaled(pixels: Vec<u8>, size: (u32, u32)) -> Vec<u8> {
    // A buffer of another size than SIZE is none of ours; the writer behind refuses what comes of it.
    let picture = image::RgbImage::from_raw(SIZE.0, SIZE.1, pixels).unwrap_or_default();
    let mut small =
        image::imageops::resize(&picture, size.0, size.1, image::imageops::FilterType::CatmullRom).into_raw();
    for value in &mut small {
        *value = ((u16::from(*value) + LEVEL / 2) / LEVEL * LEVEL) as u8;
    }
    small
}

fn wrong(error: png::EncodingError) -> FilmError {
    FilmError::Picture(PictureError(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_animation_has_its_frames_and_their_time() {
        let frame = |k: usize| Ok(vec![40 * k as u8; (3 * SIZE.0 * SIZE.1) as usize]);
        let bytes =
            animation(Reel { count: 3, rate: 20, width: SIZE.0, still: 2 }, frame).expect("three frames");
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().expect("a PNG");
        assert_eq!(reader.info().animation_control().map(|control| control.num_frames), Some(3));
        let mut pixels = vec![0; (3 * SIZE.0 * SIZE.1) as usize];
        reader.next_frame(&mut pixels).expect("the still");
        assert!(pixels.iter().all(|&value| value == 80), "a viewer that plays nothing shows frame 2");
        for k in 0..3 {
            reader.next_frame(&mut pixels).expect("a frame");
            assert!(pixels.iter().all(|&value| value == 40 * k));
            let control = reader.info().frame_control().expect("its time");
            assert_eq!((control.delay_num, control.delay_den), (1, 20));
        }
    }

    #[test]
    fn a_narrow_film_keeps_colours_and_proportion() {
        let frame = |_: usize| Ok([17, 119, 255].repeat((SIZE.0 * SIZE.1) as usize));
        let bytes = animation(Reel { count: 2, rate: 10, width: 600, still: 0 }, frame).expect("two frames");
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().expect("a PNG");
        assert_eq!((reader.info().width, reader.info().height), (600, 380));
        let mut pixels = vec![0; 3 * 600 * 380];
        reader.next_frame(&mut pixels).expect("a frame");
        assert!(pixels.chunks_exact(3).all(|pixel| pixel == [17, 119, 255]));
    }
}
