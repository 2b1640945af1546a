//! Choice of a mode among those that a webcam offers.

use crate::error::WebcamError;
use crate::mode::{Mode, PixelFormat};
use crate::video::Offers;

/// Rates that are taken, Hz: the model's step is a sixtieth of a second, and with less than every second of its frames the
/// estimate lives on predictions.
const RATES_HZ: (f64, f64) = (24.0, 62.0);
/// Smallest and largest image, pixels in a row.
const WIDTHS: std::ops::RangeInclusive<u16> = 480..=1920;
/// Image that is looked for first.
const USUAL_PIXELS: i64 = 640 * 480;

/// Chooses the mode of the camera at `path`: the fastest up to 60 Hz, of these the one nearest to 640x480 in pixels, of
/// these the one without a loss.
///
/// # Errors
/// [`WebcamError::NoFormat`], [`WebcamError::NoMode`].
pub(crate) fn choose(offers: &Offers, path: &str) -> Result<Mode, WebcamError> {
    let rank = |mode: &&Mode| {
        let [width, height] = mode.size.map(i64::from);
        let far = (width * height - USUAL_PIXELS).abs();
        (mode.rate_hz().round() as u64, -far, mode.format == PixelFormat::Yuyv)
    };
    if let Some(mode) = offers.modes.iter().filter(|mode| is_taken(mode)).max_by_key(rank) {
        return Ok(*mode);
    }
    let path = path.to_owned();
    if offers.modes.is_empty() {
        let letters = |code: &[u8; 4]| code.escape_ascii().to_string();
        return Err(WebcamError::NoFormat { path, offered: offers.formats.iter().map(letters).collect() });
    }
    let fastest = offers.modes.iter().filter(|mode| mode.rate_hz() <= RATES_HZ.1);
    let fastest = fastest.max_by(|a, b| a.rate_hz().total_cmp(&b.rate_hz())).unwrap_or(&offers.modes[0]);
    Err(WebcamError::NoMode { path, fastest: *fastest })
}

fn is_taken(mode: &Mode) -> bool {
    (RATES_HZ.0..=RATES_HZ.1).contains(&mode.rate_hz()) && WIDTHS.contains(&mode.size[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(format: PixelFormat, size: [u16; 2], hz: u32) -> Mode {
        Mode { format, size, interval: [1, hz] }
    }

    fn chosen(modes: &[Mode]) -> Result<Mode, String> {
        let formats = modes.iter().map(|mode| mode.format.code()).collect();
        choose(&Offers { formats, modes: modes.to_vec() }, "/dev/video9").map_err(|error| error.to_string())
    }

    #[test]
    fn the_fastest_then_the_usual_size_then_the_one_without_a_loss() {
        use PixelFormat::{Mjpg, Yuyv};
        let usual = mode(Yuyv, [640, 480], 30);
        let all =
            [mode(Yuyv, [1280, 720], 10), mode(Mjpg, [640, 480], 30), usual, mode(Mjpg, [1280, 720], 30)];
        assert_eq!(chosen(&all), Ok(usual));
        let fast = mode(Mjpg, [1280, 720], 60);
        assert_eq!(chosen(&[&all[..], &[fast, mode(Mjpg, [640, 480], 120)]].concat()), Ok(fast));
    }

    #[test]
    fn what_is_too_slow_or_of_another_format_is_refused_by_name() {
        let slow =
            chosen(&[mode(PixelFormat::Yuyv, [1280, 720], 10), mode(PixelFormat::Yuyv, [640, 480], 15)]);
        assert!(slow.as_ref().is_err_and(|why| why.contains("640x480 YUYV at 15 Hz")), "{slow:?}");
        let other = choose(&Offers { formats: vec![*b"H264", *b"GREY"], modes: vec![] }, "/dev/video9");
        let other = other.map_err(|error| error.to_string());
        assert!(
            other.as_ref().is_err_and(|why| why.contains("H264, GREY") && why.contains("/dev/video9")),
            "{other:?}"
        );
    }
}
