//! Turns, folders and connections for several classes of attacks.

use meniscus::blob::Model;
use meniscus::runtime::{Estimator, Memory, Turn, TurnInput};
use meniscus::surface::SurfaceProfile;
use meniscus::units::Micros;
use meniscus_platform::clock::NoClock;
use meniscus_platform::files::AlignedBytes;
use meniscus_service::run::Viewer;
use meniscus_service::sink::{StateAfter, TurnRecord, TurnSink};
use meniscus_service::timed_turn::TimedTurn;
use std::net::{SocketAddr, TcpStream};
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A port of this machine that the system chooses.
pub(crate) const LOOPBACK: ([u8; 4], u16) = ([127, 0, 0, 1], 0);

/// The shipped model.
pub(crate) fn blob() -> AlignedBytes {
    AlignedBytes::copy(meniscus_shipped::MODEL)
}

/// Runs `attack` beside a worker that hands `viewer` a turn every four milliseconds.
pub(crate) fn beside_turns(viewer: &impl Viewer, attack: impl FnOnce() + Send) {
    let bytes = blob();
    let model = Model::load(&bytes).expect("sound");
    let (over, image) = (AtomicBool::new(false), vec![90; 640 * 480]);
    std::thread::scope(|scope| {
        scope.spawn(|| viewer.show(&model));
        scope.spawn(|| {
            let (mut memory, mut field) = (Memory::default(), vec![0.0; model.field_len()]);
            let mut sink = viewer.sink();
            for number in 0.. {
                if over.load(Ordering::Relaxed) {
                    break;
                }
                let logged = turn(&model, &mut memory, &mut field, number);
                let after = Some(StateAfter { memory: &memory, outline: &image, depth: &[] });
                sink.accept(&TurnRecord { logged: &logged, field: &field, after });
                std::thread::sleep(Duration::from_millis(4));
            }
        });
        let attacked = std::panic::catch_unwind(std::panic::AssertUnwindSafe(attack));
        over.store(true, Ordering::Relaxed);
        viewer.end();
        if let Err(failure) = attacked {
            std::panic::resume_unwind(failure);
        }
    });
}

/// A turn of the estimator on a leaning surface.
fn turn(model: &Model<'_>, memory: &mut Memory, field: &mut [f32], number: u64) -> TimedTurn {
    let lean = 0.0004 * (number as f32 / 5.0).sin();
    let height_m = std::array::from_fn(|index| 0.07 + lean * (index as f32 - 10.0));
    let captured = Micros(1_000_000 + number * 16_667);
    let (variance_m2, valid) = ([1e-7; 21], [true; 21]);
    let profile =
        SurfaceProfile { height_m, variance_m2, valid, glass_x_m: Some(0.01), sequence: 0, captured };
    let estimate = Estimator::new(model).turn(memory, TurnInput::tracked(&profile), &mut NoClock, field);
    let stamp = Some(meniscus::usb::frame::Stamp { sequence: number as u32, captured });
    TimedTurn::untimed(Turn { time: captured, stamp, profile: Some(Ok(profile)), estimate })
}

/// A connection to `to` from 127.0.0.`last`, whose reads end after 20 s.
pub(crate) fn connect_from(last: u8, to: SocketAddr) -> TcpStream {
    let socket = socket2::Socket::new(socket2::Domain::IPV4, socket2::Type::STREAM, None).expect("a socket");
    socket.bind(&SocketAddr::from(([127, 0, 0, last], 0)).into()).expect("a loopback address");
    socket.connect(&to.into()).expect("it listens");
    let stream = TcpStream::from(socket);
    stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
    stream
}

/// A folder that goes with its test.
pub(crate) struct Scratch(pub(crate) PathBuf);

impl Scratch {
    pub(crate) fn new(name: &str) -> Self {
        let name: String =
            name.chars().map(|letter| if letter.is_alphanumeric() { letter } else { '-' }).collect();
        let folder = std::env::temp_dir().join(format!("meniscus-attack-{name}-{}", std::process::id()));
        let _gone = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        Self(folder)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _gone = std::fs::remove_dir_all(&self.0);
    }
}

/// The program under attack.
pub(crate) fn meniscus_command() -> Command {
    Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
}
