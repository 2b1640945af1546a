//! The streams from the device's side: shots at 60 Hz, their payloads under the device's trouble.

use super::descriptors::COLOUR_STREAMING;
use super::trouble::{At, Back, Cure, Ending, Trouble};
use super::{COLOUR, DEPTH, Device, Event, FIRST_SHOT_US, INFRARED, INTERRUPT, Life, STRIKE, shot_time_us};
use crate::camera::{Payload, Shot, Source, Stream};

impl Device {
    /// The next event up to `until_us`, in the order of time.
    pub fn due(&mut self, until_us: u64) -> Option<Event> {
        let plugged_again = self.life == Life::Struck
            && self.cure_of() == Some(Cure::Replug)
            && until_us >= self.struck_us + 15_000_000;
        if plugged_again {
            let now_us = self.struck_us + 15_000_000;
            self.unplug(now_us, Back::Same);
        }
        while let Some(started_us) = self.started_us {
            let next_us = started_us + shot_time_us(self.shots_of_start);
            if next_us > until_us || self.due.first().is_some_and(|event| event.at_us <= next_us) {
                break;
            }
            self.expose(next_us);
        }
        let first = self.due.first().is_some_and(|event| event.at_us <= until_us);
        first.then(|| self.due.remove(0))
    }

    /// When the next event can come, microseconds of the bus; `None` while nothing is started.
    #[must_use]
    pub fn next_us(&self) -> Option<u64> {
        let shot_us = self.started_us.map(|started_us| started_us + shot_time_us(self.shots_of_start));
        let due_us = self.due.first().map(|event| event.at_us);
        shot_us.into_iter().chain(due_us).min()
    }

    /// One shot, whose images are on the wire a little later.
    fn expose(&mut self, now_us: u64) {
        if self.shot == STRIKE && self.life == Life::Ahead {
            (self.life, self.struck_us) = (Life::Struck, now_us);
            if let Some(Trouble::Unplug(At::Stream, back)) = self.trouble {
                return self.unplug(now_us, back);
            }
            if self.trouble == Some(Trouble::ClockReset) {
                self.restart_clock();
            }
        }
        let shot = self.shot;
        if self.habits.replug_shot.take_if(|due| *due == shot).is_some() {
            return self.unplug(now_us, Back::Same);
        }
        if let Some(step) = self.habits.step.filter(|step| step.shot == shot) {
            self.clock_ahead_us += i64::from(step.by_us);
        }
        self.exposures.push(now_us);
        self.shot += 1;
        let since_start = self.shots_of_start;
        self.shots_of_start += 1;
        let since_us = self.habits.since_first_us(shot_time_us(shot));
        let captured_us = (FIRST_SHOT_US + since_us).wrapping_add_signed(self.clock_ahead_us);
        let size = if self.usb2(now_us) { (480, 270) } else { (640, 480) };
        let in_colour = self.committed.contains(&COLOUR_STREAMING);
        let seen = if in_colour { self.scenery.look_in_colour(shot) } else { None };
        let seen = seen.map(|(depth, colour)| (depth, (Stream::Colour, colour)));
        let (depth, beside) = match seen {
            Some(seen) => seen,
            None => {
                let (depth, infrared) = self.scenery.look(shot, size);
                let even = (Stream::Colour, &self.even[..]);
                (depth, if in_colour { even } else { (Stream::Infrared, infrared) })
            }
        };
        let payloads = self.wire.expose(&Shot { depth, beside, captured_us });
        let to_bus_us = now_us.wrapping_sub(captured_us);
        for Payload { stream, mut bytes, arrival_us } in payloads {
            if let Some(replay) = &self.replay {
                bytes = replay.payload(stream, shot, bytes);
            }
            if self.habits.loses(stream, since_start) {
                continue;
            }
            let at_us = arrival_us.wrapping_add(to_bus_us) + self.habits.delay_us(stream);
            if let Some(what) = self.afflict(stream, bytes) {
                let endpoint = match stream {
                    Stream::Depth => DEPTH,
                    Stream::Infrared => INFRARED,
                    Stream::Colour => COLOUR,
                };
                self.due.push(Event { endpoint, at_us, what });
            }
        }
        self.status(now_us);
        self.due.sort_by_key(|event| event.at_us);
    }

    /// A payload under the trouble of its stream.
    fn afflict(&mut self, stream: Stream, mut bytes: Vec<u8>) -> Option<Result<Vec<u8>, Ending>> {
        let place = usize::from(stream != Stream::Depth);
        let trouble = self.trouble;
        if self.life != Life::Struck {
            // Nobody else asks for it, and a copy of every payload is a tenth of the camera's work.
            if matches!(trouble, Some(Trouble::Frozen(_))) {
                self.last[place].clone_from(&bytes);
            }
            return Some(Ok(bytes));
        }
        match trouble {
            Some(Trouble::Quiet(_) | Trouble::DrainStuck | Trouble::ClearHaltRefused) => None,
            Some(Trouble::QuietInfrared(_) | Trouble::InterruptError(23)) if stream != Stream::Depth => None,
            Some(Trouble::Frozen(_)) => Some(Ok(self.last[place].clone())),
            Some(Trouble::Erring(_)) => {
                if let Some(flags) = bytes.get_mut(1) {
                    *flags |= 0x40;
                }
                Some(Ok(bytes))
            }
            Some(Trouble::Torn(_)) => {
                bytes.truncate(bytes.len() / 2);
                Some(Ok(bytes))
            }
            Some(Trouble::Apart(_)) if stream != Stream::Depth => {
                // The time stamp of another clock, two seconds ahead.
                if let Some(pts) = bytes.get_mut(2..6).and_then(|pts| pts.first_chunk_mut::<4>()) {
                    *pts = u32::from_le_bytes(*pts).wrapping_add(2_000_000).to_le_bytes();
                }
                Some(Ok(bytes))
            }
            Some(Trouble::Transfer(Ending::Stall, _)) if self.halted.contains(&DEPTH) && place == 0 => None,
            Some(Trouble::Transfer(ending, _)) if stream == Stream::Depth && self.strike() => {
                if ending == Ending::Stall {
                    self.halted.insert(DEPTH);
                }
                Some(Err(ending))
            }
            _ => Some(Ok(bytes)),
        }
    }

    /// Status packets that the trouble leads to.
    fn status(&mut self, at_us: u64) {
        let struck = self.life == Life::Struck;
        let what = match self.trouble {
            Some(Trouble::InterruptStalls) => Err(Ending::Stall),
            Some(Trouble::InterruptNoise) if struck => Ok(vec![0xff, 1, 2]),
            Some(Trouble::InterruptError(value)) if struck && self.struck_us == at_us => {
                Ok(vec![1, 3, 0, 7, 0, value])
            }
            _ => return,
        };
        self.due.push(Event { endpoint: INTERRUPT, at_us: at_us + 100, what });
    }
}
