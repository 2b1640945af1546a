//! Formats and modes that a device of this machine's kernel offers.

use super::layout::{CAPTURE, DISCRETE, FormatDescription, FrameInterval, FrameSize};
use super::{Offers, uapi};
use crate::mode::{Mode, PixelFormat};
use rustix::fd::BorrowedFd;

/// Most entries of a list that are requested of a driver: one that never ends a list does not stop the program.
const MOST: u32 = 256;
/// Sizes and intervals that are looked for where a driver offers a range.
const USUAL_SIZES: [[u32; 2]; 3] = [[640, 480], [1280, 720], [800, 600]];
const USUAL_INTERVALS: [[u32; 2]; 2] = [[1, 60], [1, 30]];

/// Returns what the open device offers.
pub(super) fn of(device: BorrowedFd<'_>) -> Offers {
    let mut offers = Offers::default();
    for index in 0..MOST {
        let mut format = FormatDescription { index, kind: CAPTURE, ..FormatDescription::default() };
        if uapi::enumerate_format(device, &mut format).is_err() {
            break;
        }
        offers.formats.push(format.pixel_format.to_le_bytes());
    }
    for format in PixelFormat::ALL {
        if offers.formats.contains(&format.code()) {
            add_modes(device, format, &mut offers.modes);
        }
    }
    offers
}

/// Adds the modes of one format.
fn add_modes(device: BorrowedFd<'_>, format: PixelFormat, modes: &mut Vec<Mode>) {
    let pixel_format = u32::from_le_bytes(format.code());
    for index in 0..MOST {
        let mut size = FrameSize { index, pixel_format, ..FrameSize::default() };
        if uapi::enumerate_size(device, &mut size).is_err() {
            return;
        }
        for [width, height] in sizes(&size) {
            let narrow = |pixels: u32| u16::try_from(pixels).ok();
            let (Some(w), Some(h)) = (narrow(width), narrow(height)) else { continue };
            for index in 0..MOST {
                let asked = FrameInterval { index, pixel_format, width, height, ..FrameInterval::default() };
                let mut interval = asked;
                if uapi::enumerate_interval(device, &mut interval).is_err() {
                    break;
                }
                modes.extend(intervals(&interval).map(|interval| Mode { format, size: [w, h], interval }));
                if interval.kind != DISCRETE {
                    break;
                }
            }
        }
        if size.kind != DISCRETE {
            return;
        }
    }
}

/// Sizes of an entry: its own where it is discrete, of a range the usual ones in it.
fn sizes(entry: &FrameSize) -> impl Iterator<Item = [u32; 2]> {
    let [w0, w1, w_step, h0, h1, h_step] = entry.size;
    let discrete = entry.kind == DISCRETE;
    let on = |value: u32, [least, most, step]: [u32; 3]| {
        (least..=most).contains(&value) && (value - least).is_multiple_of(step.max(1))
    };
    let within = move |[width, height]: &[u32; 2]| {
        !discrete && on(*width, [w0, w1, w_step]) && on(*height, [h0, h1, h_step])
    };
    discrete.then_some([w0, w1]).into_iter().chain(USUAL_SIZES.into_iter().filter(within))
}

/// Intervals of an entry: its own where it is discrete, of a range the usual ones in it.
fn intervals(entry: &FrameInterval) -> impl Iterator<Item = [u32; 2]> {
    let [own, most, _] = entry.interval;
    let discrete = entry.kind == DISCRETE;
    let seconds = |[numerator, denominator]: [u32; 2]| f64::from(numerator) / f64::from(denominator.max(1));
    let within =
        move |usual: &[u32; 2]| !discrete && (seconds(own)..=seconds(most)).contains(&seconds(*usual));
    discrete.then_some(own).into_iter().chain(USUAL_INTERVALS.into_iter().filter(within))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_offers_the_usual_sizes_and_rates_in_it() {
        let range = FrameSize { kind: 3, size: [320, 1280, 2, 240, 720, 2], ..FrameSize::default() };
        assert!(sizes(&range).eq(USUAL_SIZES));
        let odd = FrameSize { kind: 3, size: [320, 1280, 960, 240, 720, 2], ..FrameSize::default() };
        assert!(sizes(&odd).eq([[1280, 720]]));
        let discrete = FrameSize { kind: DISCRETE, size: [352, 288, 0, 0, 0, 0], ..FrameSize::default() };
        assert!(sizes(&discrete).eq([[352, 288]]));
        let rates =
            FrameInterval { kind: 2, interval: [[1, 50], [1, 1], [1, 1]], ..FrameInterval::default() };
        assert!(intervals(&rates).eq([[1, 30]]));
    }
}
