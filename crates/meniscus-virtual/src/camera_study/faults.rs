//! Every trouble of the simulated camera, driven through the session in virtual time: each must end in the
//! stated recovery or the stated words, none may hang, and no stale frame may come out as a fresh one.

pub use super::fault_table::TABLE;
use crate::usb::SimulatedBus;
use meniscus::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock, Losses, Pairer, Stream};
use meniscus_hil::FaultList;
use meniscus_hil::device::{Device, Habits, Lag, TestCard, Trouble};
use meniscus_usb::buffer::Buffer;
use meniscus_usb::camera::{CameraError, CameraHealth, Note, OutlineImage, Rung, Session, Settings, Sink};
use meniscus_usb::transport::Transport;

/// Required outcome of a fault.
#[derive(Clone, Copy, Debug)]
pub enum Must {
    /// No session, and these words.
    Refuse(&'static [&'static str]),
    /// Frames, and no rung is taken.
    Stream(fn(&Books) -> bool),
    /// Frames, no rung is taken, and the camera reports these words.
    Report(&'static [&'static str]),
    /// Frames again, and this is the highest rung that was taken.
    Recover(Rung, fn(&Books) -> bool),
    /// The session ends with these words.
    GiveUp(&'static [&'static str]),
}

/// Counts of a run.
#[derive(Clone, Copy, Debug)]
pub struct Books {
    /// The session's counters.
    pub health: CameraHealth,
    /// Losses of the assemblers, depth then outline.
    pub losses: [Losses; 2],
    /// The depth unit that holds.
    pub depth_unit_um: u32,
    /// The link was slow and the images are smaller for it.
    pub stepped_down: bool,
}

impl Books {
    /// Whether one of the streams has lost something of this kind.
    #[must_use]
    pub fn lost(&self, of: fn(&Losses) -> u32) -> bool {
        self.losses.iter().any(|losses| of(losses) > 0)
    }
}

/// Calls of the session after which it hangs.
const PATIENCE: u32 = 200_000;

/// Assembles and pairs, and holds every frame against what the camera put into it.
#[derive(Debug)]
pub struct Reader {
    /// Depth and outline.
    assemblers: [(Assembler<'static>, Option<u16>, u64); 2],
    clock: DeviceClock,
    pairer: Pairer,
    /// Buffers that are free.
    pub spare: Vec<Buffer>,
    /// Pairs so far.
    pub pairs: u32,
    wanted: u32,
    patience: u32,
    /// Events of the camera.
    pub notes: Vec<Note>,
    /// The first thing that must never happen, if it did.
    pub wrong: Option<String>,
}

impl Reader {
    /// For images of so many bytes, depth and outline, until there are `wanted` pairs.
    #[must_use]
    pub fn new(image_bytes: [usize; 2], buffer_bytes: usize, wanted: u32) -> Self {
        let assembler = |bytes: usize| {
            (Assembler::keeping_two(Box::leak(vec![0; 2 * bytes].into_boxed_slice())), None, 0)
        };
        Self {
            assemblers: image_bytes.map(assembler),
            clock: DeviceClock::default(),
            pairer: Pairer::new(16_667, 2),
            spare: (0..4).map(|_| Buffer::new(buffer_bytes)).collect(),
            pairs: 0,
            wanted,
            patience: PATIENCE,
            notes: Vec::new(),
            wrong: None,
        }
    }

    /// Losses of the assemblers, depth then outline.
    #[must_use]
    pub fn losses(&self) -> [Losses; 2] {
        [self.assemblers[0].0.losses(), self.assemblers[1].0.losses()]
    }

    /// Judges a payload.
    fn judge(&mut self, stream: Stream, payload: &[u8]) -> Result<(), String> {
        let (assembler, last, captured_us) = &mut self.assemblers[usize::from(stream == Stream::Outline)];
        let AssemblyOutcome::Frame(frame) = assembler.push(payload, &mut self.clock) else { return Ok(()) };
        let number = [frame.pixels[0], frame.pixels[1]];
        if frame.pixels.chunks_exact(2).any(|pair| pair != number) {
            return Err(format!("{stream:?}: a frame of two shots"));
        }
        let shot = u16::from_le_bytes(number);
        let ahead = last.map_or(1, |last| shot.wrapping_sub(last));
        if !(1..32_768).contains(&ahead) {
            return Err(format!("{stream:?}: shot {shot} is not newer than the last one"));
        }
        if frame.stamp.captured.0 <= *captured_us {
            return Err(format!("{stream:?}: time stands still"));
        }
        (*last, *captured_us) = (Some(shot), frame.stamp.captured.0);
        if let Some(pair) = self.pairer.offer(stream, frame.stamp) {
            let [depth, outline] = &self.assemblers;
            let images = [depth.0.pixels_of(pair.depth), outline.0.pixels_of(pair.outline)];
            let [Some(depth), Some(outline)] = images else { return Err("a pair without its images".into()) };
            if depth[..2] != outline[..2] {
                return Err("a pair of two shots".into());
            }
            self.pairs += 1;
        }
        Ok(())
    }
}

impl Sink for Reader {
    fn wanted(&mut self) -> bool {
        self.patience = self.patience.saturating_sub(1);
        if self.patience == 0 {
            self.wrong.get_or_insert("the session hangs".into());
        }
        self.pairs < self.wanted && self.wrong.is_none()
    }

    fn spare(&mut self) -> Option<Buffer> {
        self.spare.pop()
    }

    fn deliver(&mut self, stream: Stream, payload: Buffer) -> bool {
        if let Err(wrong) = self.judge(stream, &payload) {
            self.wrong.get_or_insert(wrong);
        }
        self.spare.push(payload);
        true
    }

    fn dropped(&mut self) {}

    fn note(&mut self, note: Note) {
        self.notes.push(note);
    }
}

/// Habits under which every trouble must end the same way, each with its name.
pub const HABITS: [(&str, Habits); 9] = [
    ("steady", STEADY),
    ("clock-restarts", RESTARTS),
    ("clock-restarts, first depth frame lost", Habits { lost_at_start: [1, 0], ..RESTARTS }),
    ("clock-restarts, first outline frame lost", Habits { lost_at_start: [0, 1], ..RESTARTS }),
    ("clock-restarts, three depth frames lost", Habits { lost_at_start: [3, 0], ..RESTARTS }),
    ("clock-restarts, up for 40 minutes", Habits { up_us: 2_400_000_000, lost_at_start: [0, 1], ..RESTARTS }),
    ("clock-restarts, depth lags", Habits { lags: Some(Lag::Depth), ..RESTARTS }),
    ("clock-restarts, outline lags", Habits { lags: Some(Lag::Beside), lost_at_start: [1, 0], ..RESTARTS }),
    ("start astride the rollover", Habits { up_us: u32::MAX - 1_009_999, lost_at_start: [1, 0], ..STEADY }),
];

/// A camera whose clock goes on, and whose streams start and arrive together.
const STEADY: Habits = Habits {
    clock_restarts: false,
    up_us: 0,
    lost_at_start: [0; 2],
    lags: None,
    drift_ppm: 0,
    step: None,
    replug_shot: None,
};

/// A camera whose clock begins anew with its power.
const RESTARTS: Habits = Habits { clock_restarts: true, ..STEADY };

/// A simulated bus in virtual time.
#[must_use]
pub fn bus(trouble: Option<Trouble>) -> SimulatedBus {
    bus_with(trouble, Habits::default())
}

/// The same with a camera of these habits.
#[must_use]
pub fn bus_with(trouble: Option<Trouble>, habits: Habits) -> SimulatedBus {
    let device = Device::new(Box::new(TestCard::default()), trouble, FaultList::default(), 1);
    SimulatedBus::new(device.with_habits(habits))
}

/// Connects to a camera with these habits and reads 240 pairs of depth and this image: four seconds, the trouble begins in the second one.
///
/// # Errors
/// When there is no session.
pub fn run(
    trouble: Option<Trouble>,
    outline: OutlineImage,
    habits: Habits,
) -> Result<(Books, Reader, Result<(), CameraError>), CameraError> {
    let mut session =
        Session::connect(bus_with(trouble, habits), Settings { outline, ..Settings::default() })?;
    let bytes = session.plan().streams.map(|stream| stream.frame_bytes as usize);
    let mut reader = Reader::new(bytes, session.buffer_bytes(), 240);
    let ended = session.stream(&mut reader);
    if session.transport().in_flight() > 0 {
        reader.wrong.get_or_insert("transfers are left in flight at the end".into());
    }
    let books = Books {
        health: session.health(),
        losses: reader.losses(),
        depth_unit_um: session.connected().depth_unit_um,
        stepped_down: session.connected().stepped_down,
    };
    Ok((books, reader, ended))
}

/// Whether an error has the words it must have.
///
/// # Errors
/// What is missing.
pub fn says(error: &CameraError, words: &[&str]) -> Result<(), String> {
    let text = error.to_string();
    match words.iter().chain(&["What to do: "]).find(|word| !text.contains(**word)) {
        Some(word) => Err(format!("`{word}` is missing in: {text}")),
        None => Ok(()),
    }
}

/// Drives one trouble of a camera with these habits that streams this image beside the depth.
///
/// # Errors
/// What came of it instead of what must.
pub fn check(name: &str, must: Must, outline: OutlineImage, habits: Habits) -> Result<(), String> {
    let named = |why: String| format!("{name}: {why}");
    let trouble = Trouble::find(name).ok_or_else(|| named("there is no such trouble".into()))?;
    let (books, reader, ended) = match (run(Some(trouble), outline, habits), must) {
        (Err(error), Must::Refuse(words)) => return says(&error, words).map_err(named),
        (Err(error), _) => return Err(named(format!("refused: {error}"))),
        (Ok(ran), _) => ran,
    };
    let account = || format!("{:?} {:?} {:?}", reader.notes, books.health, books.losses);
    if let Some(wrong) = &reader.wrong {
        return Err(named(wrong.clone()));
    }
    match (ended, must) {
        (Err(error), Must::GiveUp(words)) => says(&error, words).map_err(named),
        (Ok(()), Must::Stream(as_expected)) if books.health.rungs == [0; 5] && as_expected(&books) => Ok(()),
        (Ok(()), Must::Report(words)) if books.health.rungs == [0; 5] => {
            let notes: Vec<String> = reader.notes.iter().map(Note::to_string).collect();
            let all = words.iter().all(|word| notes.iter().any(|note| note.contains(word)));
            if all { Ok(()) } else { Err(named(account())) }
        }
        (Ok(()), Must::Recover(rung, as_expected)) => {
            let taken = reader.notes.iter().filter_map(|note| match note {
                Note::Trouble(_, rung) => Some(*rung),
                Note::Failed(_) | Note::Recovered | Note::Remark(_) | Note::Reported(_) => None,
            });
            let recovered = reader.notes.last() == Some(&Note::Recovered);
            let good = taken.max() == Some(rung) && recovered && as_expected(&books);
            if good { Ok(()) } else { Err(named(account())) }
        }
        (ended, _) => Err(named(format!("{ended:?} {}", account()))),
    }
}
