//! The live page without a browser: who is let in, what travels, and that nobody is waited for.
//! `tests/browser.rs` looks at it with one.

#[path = "support/server.rs"]
#[allow(dead_code, reason = "each test takes what it needs of it")]
mod server;

#[path = "support/corrected.rs"]
mod corrected;

use corrected::corrected;
use meniscus::blob::Model;
use meniscus::runtime::{Estimator, Memory, Turn, TurnInput};
use meniscus::surface::{Config, SurfaceProfile};
use meniscus::units::Micros;
use meniscus_platform::clock::NoClock;
use meniscus_platform::files::AlignedBytes;
use meniscus_service::run::Viewer;
use meniscus_service::sink::{StateAfter, TurnRecord, TurnSink};
use meniscus_service::timed_turn::TimedTurn;
use meniscus_ui::page::{Page, Token, VIEWERS_EACH};
use serde_json::Value;
use server::{ask, frame, taken, viewer};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const LOOPBACK: ([u8; 4], u16) = ([127, 0, 0, 1], 0);

fn blob() -> AlignedBytes {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../models/glycerine.blob");
    AlignedBytes::read(std::path::Path::new(path)).expect("the shipped model")
}

/// A turn of the estimator on a leaning surface, and its full field.
fn turn(model: &Model<'_>, memory: &mut Memory, field: &mut [f32], number: u64) -> TimedTurn {
    let mut height_m = [0.0; 21];
    for (index, height) in height_m.iter_mut().enumerate() {
        *height = 0.07 + 0.0004 * (index as f32 - 10.0) * (number as f32 / 5.0).sin();
    }
    let captured = Micros(1_000_000 + number * 16_667);
    let (variance_m2, valid) = ([1e-7; 21], [true; 21]);
    let profile =
        SurfaceProfile { height_m, variance_m2, valid, glass_x_m: Some(0.0), sequence: 0, captured };
    let estimate = Estimator::new(model).turn(memory, TurnInput::tracked(&profile), &mut NoClock, field);
    let turn = Turn { time: captured, stamp: None, profile: Some(Ok(profile)), estimate };
    TimedTurn { latency_us: 900, turn_us: 800, ..TimedTurn::untimed(turn) }
}

/// Runs `test` against an open page of the shipped model.
fn with_page(token: Option<Token>, test: impl FnOnce(SocketAddr, &Page) + Send) -> Duration {
    with_page_of(&blob(), token, test)
}

/// Runs `test` against an open page of the model `bytes` that is fed a turn every four milliseconds; gives the longest hand-over.
fn with_page_of(
    bytes: &AlignedBytes,
    token: Option<Token>,
    test: impl FnOnce(SocketAddr, &Page) + Send,
) -> Duration {
    let model = Model::load(bytes).expect("sound");
    let config = Config::new(meniscus::surface::Settings::default()).expect("sound");
    let page = Page::open(&model, config, "a test", LOOPBACK.into(), token).expect("it opens");
    let (address, over) = (page.address(), AtomicBool::new(false));
    let image = vec![90; 640 * 480];
    std::thread::scope(|scope| {
        scope.spawn(|| page.show(&model));
        let worker = scope.spawn(|| {
            let (mut memory, mut field) = (Memory::default(), vec![0.0; model.field_len()]);
            let (mut longest, mut sink) = (Duration::ZERO, page.sink());
            for number in 0.. {
                if over.load(Ordering::Relaxed) {
                    break;
                }
                let logged = turn(&model, &mut memory, &mut field, number);
                let begun = Instant::now();
                let after = Some(StateAfter { memory: &memory, outline: &image, depth: &[] });
                sink.accept(&TurnRecord { logged: &logged, field: &field, after });
                longest = longest.max(begun.elapsed());
                std::thread::sleep(Duration::from_millis(4));
            }
            longest
        });
        let tested = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| test(address, &page)));
        over.store(true, Ordering::Relaxed);
        page.end();
        if let Err(failure) = tested {
            std::panic::resume_unwind(failure);
        }
        worker.join().expect("the worker goes on")
    })
}

fn get(path: &str, host: &str) -> String {
    format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n")
}

#[test]
fn files_are_served_and_strangers_refused_with_words() {
    with_page(None, |address, page| {
        let host = address.to_string();
        let (status, body) = ask(address, &get("/", &host));
        assert!(status == 200 && body.contains("page.js"), "{status}");
        for path in ["/style.css", "/page.js", "/liquid.js", "/twgl.js", "/licences.txt"] {
            let (status, body) = ask(address, &get(path, &host));
            assert!(status == 200 && body.len() > 500, "{path}: {status}");
        }
        let (status, body) = ask(address, &get("/", "evil.example"));
        assert!(status == 403 && body.contains("the address that the program printed"), "{status} {body}");
        assert_eq!(ask(address, &get("/../Cargo.toml", &host)).0, 404);
        let long = format!("{}X: {}\r\n", get("/", &host), "y".repeat(20_000));
        assert_eq!(ask(address, &long).0, 431);
        assert_eq!(ask(address, &get("/live", &host)).0, 400, "no web socket");
        assert!(page.counters().refused.load(Ordering::Relaxed) >= 4);
    });
}

#[test]
fn figures_are_there_for_prometheus_and_rise_with_the_turns() {
    with_page(None, |address, page| {
        let host = address.to_string();
        let turns = || {
            let (status, body) = ask(address, &get("/metrics", &host));
            assert_eq!(status, 200, "{body}");
            let line = body.lines().find_map(|line| line.strip_prefix("meniscus_turns_total "));
            line.unwrap_or_else(|| panic!("no turns: {body}")).parse::<f64>().expect("a number")
        };
        let first = turns();
        assert!(turns() > first, "every scrape sees a new turn");
        page.end();
    });
    // A page that shows nothing any more says so.
    let bytes = blob();
    let model = Model::load(&bytes).expect("sound");
    let config = Config::new(meniscus::surface::Settings::default()).expect("sound");
    let page = Page::open(&model, config, "", LOOPBACK.into(), None).expect("it opens");
    let (status, body) = ask(page.address(), &get("/metrics", &page.address().to_string()));
    assert!(status == 503 && body.contains("No turn came"), "{status} {body}");
}

#[test]
fn without_the_token_there_is_nothing_and_no_token_only_on_loopback() {
    let token = Token::generate().expect("random");
    let known = token.reveal().to_owned();
    with_page(Some(token), |address, page| {
        let host = address.to_string();
        for path in ["/", "/model", "/metrics", "/?token=", "/model?token=0123456789abcdef0123456789"] {
            let (status, body) = ask(address, &get(path, &host));
            assert!(status == 403 && body.contains("The token in the address"), "{path}: {status}");
        }
        assert_eq!(viewer(address, "/live").err(), Some(403));
        assert!(page.url().ends_with(&format!("/?token={known}")));
        assert_eq!(ask(address, &get(&format!("/?token={known}"), &host)).0, 200);
        assert!(viewer(address, &format!("/live?token={known}")).is_ok());
    });
    let bytes = blob();
    let model = Model::load(&bytes).expect("sound");
    let config = Config::new(meniscus::surface::Settings::default()).expect("sound");
    let error = Page::open(&model, config, "", ([0, 0, 0, 0], 0).into(), None).expect_err("others reach it");
    assert!(format!("{error}").contains("no token keeps them out"), "{error}");
    let page = Page::open(&model, config, "", LOOPBACK.into(), None).expect("it opens");
    let error = Page::open(&model, config, "", page.address(), None).expect_err("taken");
    assert!(format!("{error}").contains("What to do: end it, or choose another port"), "{error}");
}

/// The field that the page decodes is the one of the turn: rest + sum of c_j scale_j column_j, from the bytes sent.
#[test]
fn the_field_of_the_bytes_is_the_field_of_the_turn() {
    with_page(None, |address, _| {
        let (bytes, mut memory) = (blob(), Memory::default());
        let model = Model::load(&bytes).expect("sound");
        let mut field = vec![0.0; model.field_len()];
        let mut socket = viewer(address, "/live").expect("let in");
        taken(&mut socket, 0, 60);
        // A second from the first frame the window is full and the liquid has been moved.
        let wanted = (0..).find_map(|_| {
            let (number, bytes) = frame(&mut socket).expect("a frame");
            taken(&mut socket, number, 60);
            let time = f64::from_le_bytes(bytes[8..16].try_into().expect("eight bytes"));
            (bytes[1] == 1 && time > 2.0).then_some((time, bytes))
        });
        let (time, frame) = wanted.expect("a frame that tracks");
        let number = ((time - 1.0) / 0.016_667).round() as u64;
        (0..=number).for_each(|number| {
            turn(&model, &mut memory, &mut field, number);
        });
        let decoded = decode(&http_body(address, "/model"), &frame);
        assert_eq!(decoded.len(), field.len());
        let norm =
            |numbers: &mut dyn Iterator<Item = f32>| numbers.map(|x| f64::from(x).powi(2)).sum::<f64>();
        let mut first = 0;
        for group in &model.decoder.groups {
            let range = first..first + group.rest.len();
            first = range.end;
            let rest = group.rest.iter();
            let moved = norm(&mut field[range.clone()].iter().zip(rest).map(|(a, b)| a - b));
            let off = norm(&mut field[range.clone()].iter().zip(&decoded[range]).map(|(a, b)| a - b));
            assert!(moved > 0.0, "nothing moved, so nothing is shown");
            assert!(off.sqrt() < 2e-4 * moved.sqrt(), "off by {} of {}", off.sqrt(), moved.sqrt());
        }
    });
}

/// The bytes behind the head of an answer.
fn http_body(address: SocketAddr, path: &str) -> Vec<u8> {
    use std::io::{Read, Write};
    let mut stream = std::net::TcpStream::connect(address).expect("it listens");
    write!(stream, "{}\r\n", get(path, "localhost")).expect("sent");
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes).expect("an answer");
    let head = bytes.windows(4).position(|part| part == b"\r\n\r\n").expect("a head");
    bytes.split_off(head + 4)
}

/// The full field as the page makes it from the bytes of `/model` and of a frame.
fn decode(bases: &[u8], frame: &[u8]) -> Vec<f32> {
    let length = u32::from_le_bytes(bases[..4].try_into().expect("four bytes")) as usize;
    let facts: Value = serde_json::from_slice(&bases[4..4 + length]).expect("JSON");
    let float = |at: usize, bytes: &[u8]| f32::from_le_bytes(bytes[at..at + 4].try_into().expect("four"));
    let count = |value: &Value| value.as_array().map_or(0, Vec::len);
    let numbers = 8 * count(&facts["numbers"]);
    let mut coefficient = 16 + numbers + 4 * count(&facts["profiles"]) * count(&facts["abscissae"]);
    let (mut at, mut field) = (4 + length, Vec::new());
    for group in facts["groups"].as_array().expect("groups") {
        let of = |name: &str| group[name].as_u64().expect("a number") as usize;
        let (rows, rank) = (of("numbers"), of("rank"));
        let mut out: Vec<f32> = (0..rows).map(|row| float(at + 4 * row, bases)).collect();
        let (scales, columns) = (at + 4 * rows, at + 4 * (rows + rank));
        for column in 0..rank {
            let weight = float(coefficient, frame) * float(scales + 4 * column, bases);
            coefficient += 4;
            for (row, out) in out.iter_mut().enumerate() {
                let place = columns + 2 * (column * rows + row);
                *out += weight * f32::from(i16::from_le_bytes([bases[place], bases[place + 1]]));
            }
        }
        at = (columns + 2 * rows * rank).next_multiple_of(4);
        field.append(&mut out);
    }
    assert_eq!(coefficient, frame.len(), "every coefficient was used");
    field
}

/// Of a corrected model the page gets positions and heights, a sentence about the rest, and no number of it.
#[test]
fn the_page_gets_no_number_of_an_unknown_group() {
    with_page_of(&corrected(), None, |address, _| {
        let bases = http_body(address, "/model");
        let length = u32::from_le_bytes(bases[..4].try_into().expect("four bytes")) as usize;
        let facts: Value = serde_json::from_slice(&bases[4..4 + length]).expect("JSON");
        assert_eq!(facts["known"], serde_json::json!(["q", "surface"]));
        let sentence = facts["unknown"].as_str().expect("a sentence");
        assert!(sentence.contains("Velocity, internal energy, normal stress and shear stress are not known"));
        for group in facts["groups"].as_array().expect("groups") {
            let known = group["name"] == "q";
            let empty = group["rank"] == 0 && group["numbers"] == 0;
            assert_eq!((group["known"] == true, !empty), (known, known), "{group}");
        }
        let mut socket = viewer(address, "/live").expect("let in");
        taken(&mut socket, 0, 60);
        let (_, frame) = frame(&mut socket).expect("a frame");
        let names = facts["numbers"].as_array().expect("names");
        let number = |name: &str| {
            let place = 16 + 8 * names.iter().position(|one| one == name).expect("it travels");
            f64::from_le_bytes(frame[place..place + 8].try_into().expect("eight bytes"))
        };
        let unknown =
            ["v_half", "e_half", "sigma_half", "tau_half", "slosh_j", "heat_j", "step_heat", "step_work"];
        for name in unknown {
            assert!(number(name).is_nan(), "{name} is {}", number(name));
        }
        assert!(number("q_half").is_finite() && number("energy_residual").is_finite());
        // The positions of 2134 tracers, from the coefficients that came.
        assert_eq!(decode(&bases, &frame).len(), 3 * 2134);
    });
}

/// One viewer never says that it took anything, one is quick; the hand-over comes back at once each time.
#[test]
fn a_viewer_that_takes_nothing_gets_three_frames_and_holds_up_nobody() {
    let longest = with_page(None, |address, page| {
        let mut idle = viewer(address, "/live").expect("let in");
        taken(&mut idle, 0, 60);
        let mut quick = viewer(address, "/live").expect("let in");
        taken(&mut quick, 0, 60);
        let (begun, mut got, mut last) = (Instant::now(), 0, 0);
        while begun.elapsed() < Duration::from_secs(2) {
            let (number, _) = frame(&mut quick).expect("a frame");
            assert!(number > last, "the newest wins");
            last = number;
            taken(&mut quick, number, 60);
            got += 1;
        }
        assert!(got > 50, "{got} frames in two seconds");
        assert!(got < 140, "{got} frames in two seconds: more than were asked for");
        let mut held = vec![];
        while let Some((number, _)) = frame(&mut idle) {
            held.push(number);
        }
        assert_eq!(held.len(), 3, "{held:?}, then the connection was closed");
        assert!(page.counters().sent.load(Ordering::Relaxed) >= got + 3);
    });
    assert!(longest < Duration::from_millis(250), "a hand-over took {longest:?}");
}

#[test]
fn rates_are_kept_nonsense_ends_and_there_is_room_for_so_many() {
    with_page(None, |address, _| {
        let mut slow = viewer(address, "/live").expect("let in");
        taken(&mut slow, 0, 10);
        let begun = Instant::now();
        let got = (0..)
            .take_while(|_| {
                let (number, _) = frame(&mut slow).expect("a frame");
                taken(&mut slow, number, 10);
                begun.elapsed() < Duration::from_secs(2)
            })
            .count();
        assert!((10..=24).contains(&got), "{got} frames in two seconds at 10 Hz");
        for nonsense in [vec![0; 7], vec![0; 8], vec![255; 8], vec![1; 2000]] {
            let mut socket = viewer(address, "/live").expect("let in");
            socket.send(tungstenite::Message::binary(nonsense)).expect("sent");
            assert!(frame(&mut socket).is_none(), "a viewer that says nonsense is let go");
        }
        let mut all = vec![slow];
        while all.len() < VIEWERS_EACH {
            // Those let go above may need a moment to leave.
            match viewer(address, "/live") {
                Ok(socket) => all.push(socket),
                Err(status) => assert_eq!(status, 503),
            }
        }
        assert_eq!(viewer(address, "/live").err(), Some(503));
    });
}
