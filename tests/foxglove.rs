//! Foxglove's topics, as a client on its WebSocket and a reader of the file get them.

#[path = "support/corrected.rs"]
mod corrected;

use corrected::corrected;
use meniscus::blob::Model;
use meniscus::runtime::{Estimator, Memory, Turn, TurnInput};
use meniscus::surface::{Config, Settings, SurfaceProfile};
use meniscus::units::Micros;
use meniscus_platform::clock::NoClock;
use meniscus_platform::files::AlignedBytes;
use meniscus_service::run::Viewer;
use meniscus_service::sink::{StateAfter, TurnRecord, TurnSink};
use meniscus_service::timed_turn::TimedTurn;
use meniscus_ui::foxglove::{Error, Foxglove};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

const LOOPBACK: ([u8; 4], u16) = ([127, 0, 0, 1], 0);

/// Every topic with its schema.
const TOPICS: [(&str, &str); 6] = [
    ("/camera/calibration", "foxglove.CameraCalibration"),
    ("/camera/infrared", "foxglove.CompressedImage"),
    ("/liquid/estimate", "meniscus.Estimate"),
    ("/liquid/surface", "foxglove.SceneUpdate"),
    ("/liquid/tracers", "foxglove.PointCloud"),
    ("/tf", "foxglove.FrameTransform"),
];

fn config() -> Config {
    Config::new(Settings::default()).expect("sound")
}

/// A turn of the estimator on a leaning surface that the camera has seen.
fn turn(model: &Model<'_>, memory: &mut Memory, field: &mut [f32], number: u64) -> TimedTurn {
    let lean = 0.0004 * (number as f32 / 5.0).sin();
    let height_m = std::array::from_fn(|index| 0.07 + lean * (index as f32 - 10.0));
    let captured = Micros(1_000_000 + number * 16_667);
    let (variance_m2, valid) = ([1e-7; 21], [true; 21]);
    let profile =
        SurfaceProfile { height_m, variance_m2, valid, glass_x_m: Some(0.01), sequence: 0, captured };
    let estimate = Estimator::new(model).turn(memory, TurnInput::tracked(&profile), &mut NoClock, field);
    let stamp = Some(meniscus::usb::frame::Stamp { sequence: number as u32, captured });
    let turn = Turn { time: captured, stamp, profile: Some(Ok(profile)), estimate };
    TimedTurn { latency_us: 900, turn_us: 800, ..TimedTurn::untimed(turn) }
}

/// Runs `test` beside a worker that offers a turn every four milliseconds; gives the longest hand-over.
fn with_turns(foxglove: &Foxglove, test: impl FnOnce() + Send) -> Duration {
    with_turns_of(&AlignedBytes::copy(meniscus_shipped::MODEL), foxglove, test)
}

/// The same with the model `bytes`.
fn with_turns_of(bytes: &AlignedBytes, foxglove: &Foxglove, test: impl FnOnce() + Send) -> Duration {
    let model = Model::load(bytes).expect("sound");
    let (over, image) = (AtomicBool::new(false), vec![90; 640 * 480]);
    std::thread::scope(|scope| {
        scope.spawn(|| foxglove.show(&model));
        let (over, image, model) = (&over, &image, &model);
        let worker = scope.spawn(move || {
            let (mut memory, mut field) = (Memory::default(), vec![0.0; model.field_len()]);
            let (mut number, mut longest, mut sink) = (0, Duration::ZERO, foxglove.sink());
            while !over.load(Ordering::Relaxed) {
                let logged = turn(model, &mut memory, &mut field, number);
                let begun = Instant::now();
                let after = Some(StateAfter { memory: &memory, outline: image, depth: &[] });
                sink.accept(&TurnRecord { logged: &logged, field: &field, after });
                longest = longest.max(begun.elapsed());
                number += 1;
                std::thread::sleep(Duration::from_millis(4));
            }
            longest
        });
        test();
        over.store(true, Ordering::Relaxed);
        foxglove.end();
        worker.join().expect("it ended")
    })
}

/// A client that has subscribed to every topic; its subscriptions' numbers are those of [`TOPICS`].
fn client(port: u16) -> WebSocket<TcpStream> {
    let stream = TcpStream::connect(("127.0.0.1", port)).expect("it listens");
    stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a time");
    let mut request = format!("ws://127.0.0.1:{port}").into_client_request().expect("an address");
    let protocol = "foxglove.sdk.v1".parse().expect("a header");
    request.headers_mut().insert("Sec-WebSocket-Protocol", protocol);
    let (mut socket, _) = tungstenite::client(request, stream).expect("it answers");
    let mut channels = BTreeMap::new();
    while channels.len() < TOPICS.len() {
        let Message::Text(text) = socket.read().expect("a message") else { continue };
        let message: Value = serde_json::from_str(&text).expect("JSON");
        for channel in message["channels"].as_array().into_iter().flatten() {
            let name = |key: &str| channel[key].as_str().expect("a name").to_owned();
            channels.insert((name("topic"), name("schemaName")), channel["id"].as_u64().expect("a number"));
        }
    }
    let wanted: Vec<Value> = TOPICS
        .iter()
        .enumerate()
        .map(|(id, (topic, schema))| {
            let channel = channels.get(&((*topic).to_owned(), (*schema).to_owned()));
            json!({ "id": id, "channelId": channel.unwrap_or_else(|| panic!("{topic} of {schema}: {channels:?}")) })
        })
        .collect();
    let subscribe = json!({ "op": "subscribe", "subscriptions": wanted });
    socket.send(Message::text(subscribe.to_string())).expect("sent");
    socket
}

#[test]
fn a_client_gets_every_topic_and_the_worker_waits_for_nobody() {
    let foxglove =
        Foxglove::open(config(), Some(&SocketAddr::from(LOOPBACK).into()), None).expect("it opens");
    let port = foxglove.port().expect("it listens");
    let longest = with_turns(&foxglove, || {
        let mut socket = client(port);
        let (mut seen, mut tracking) = (BTreeSet::new(), false);
        while seen.len() < TOPICS.len() || !tracking {
            let Message::Binary(message) = socket.read().expect("a message") else { continue };
            // MessageData: 1, subscription, time in ns, the message.
            let (head, body) = message.split_at(13);
            assert_eq!(head[0], 1);
            let id = u32::from_le_bytes(head[1..5].try_into().expect("four bytes")) as usize;
            let time = u64::from_le_bytes(head[5..13].try_into().expect("eight bytes"));
            assert!((time / 1000 - 1_000_000).is_multiple_of(16_667), "the camera's time: {time} ns");
            match TOPICS[id].0 {
                "/liquid/estimate" => {
                    let estimate: Value = serde_json::from_slice(body).expect("JSON");
                    tracking |= estimate["mode"] == "tracking";
                    assert_eq!(estimate["measured"].as_array().map(Vec::len), Some(21));
                    assert_eq!(estimate["ahead"].as_array().map(Vec::len), Some(21));
                }
                "/liquid/tracers" => assert!(body.len() > 2134 * 40, "{} bytes", body.len()),
                "/camera/infrared" => {
                    let jpeg = body.windows(3).any(|bytes| bytes == [0xff, 0xd8, 0xff]);
                    assert!(jpeg, "an image");
                }
                _ => assert!(!body.is_empty()),
            }
            seen.insert(id);
        }
    });
    assert!(longest < Duration::from_millis(50), "a turn was held up for {longest:?}");
    let books = foxglove.close().expect("it closes");
    assert!(books.turns > 0 && books.images > 0, "{books:?}");
}

fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("foxglove");
    std::fs::create_dir_all(&folder).expect("a folder");
    folder.join(name)
}

/// Messages of each topic with its schema.
fn messages(bytes: &[u8]) -> BTreeMap<(String, String), usize> {
    let mut counts = BTreeMap::new();
    let options = mcap::read::Options::IgnoreEndMagic;
    let stream = mcap::MessageStream::new_with_options(bytes, options.into()).expect("it is MCAP");
    for message in stream.map_while(Result::ok) {
        let schema = message.channel.schema.as_ref().map_or(String::new(), |schema| schema.name.clone());
        *counts.entry((message.channel.topic.clone(), schema)).or_default() += 1;
    }
    counts
}

#[test]
fn a_file_holds_the_same_topics_and_a_torn_one_what_was_before() {
    let path = file("run.mcap");
    let foxglove = Foxglove::open(config(), None, Some(&path)).expect("it opens");
    with_turns(&foxglove, || std::thread::sleep(Duration::from_millis(1500)));
    let books = foxglove.close().expect("it closes");
    let bytes = std::fs::read(&path).expect("the file");
    let whole = messages(&bytes);
    for (topic, schema) in TOPICS {
        let count = whole.get(&(topic.to_owned(), schema.to_owned())).copied().unwrap_or(0);
        let due = match topic {
            "/camera/calibration" | "/camera/infrared" => books.images,
            "/tf" => books.turns + books.images,
            _ => books.turns,
        };
        assert_eq!(count as u64, due, "{topic}: {whole:?}");
    }
    assert!(books.turns > 20 && books.images > 3, "{books:?}");
    let torn: usize = messages(&bytes[..bytes.len() * 3 / 4]).values().sum();
    assert!(torn > 0 && torn < whole.values().sum(), "{torn} of {whole:?}");
}

/// Of a corrected model the MCAP file has the positions of the tracers and no other field, and no energies.
#[test]
fn a_file_has_no_number_of_an_unknown_group() {
    let path = file("corrected.mcap");
    let foxglove = Foxglove::open(config(), None, Some(&path)).expect("it opens");
    with_turns_of(&corrected(), &foxglove, || std::thread::sleep(Duration::from_millis(500)));
    foxglove.close().expect("it closes");
    let bytes = std::fs::read(&path).expect("the file");
    let (mut clouds, mut estimates) = (0, 0);
    for message in
        mcap::MessageStream::new(&bytes).expect("it is MCAP").map(|message| message.expect("whole"))
    {
        match message.channel.topic.as_str() {
            "/liquid/tracers" => {
                let has = |name: &str| message.data.windows(name.len()).any(|part| part == name.as_bytes());
                for name in ["speed", "pressure", "shear"] {
                    assert!(!has(name), "a cloud with {name}");
                }
                // Three numbers a tracer, and the names of the three fields.
                assert!((2134 * 12..2134 * 12 + 500).contains(&message.data.len()), "{}", message.data.len());
                clouds += 1;
            }
            "/liquid/estimate" => {
                let estimate: Value = serde_json::from_slice(&message.data).expect("JSON");
                assert_eq!(estimate["known"], json!(["q", "surface"]));
                assert!(estimate["unknown"].as_str().is_some_and(|why| why.contains("meniscus learn")));
                for name in ["slosh_energy", "heat", "work", "produced"] {
                    assert!(estimate[name].is_null(), "{name}: {}", estimate[name]);
                }
                estimates += 1;
            }
            _ => {}
        }
    }
    assert!(clouds > 5 && estimates > 5, "{clouds} clouds, {estimates} estimates");
}

#[test]
fn what_cannot_be_opened_says_why_and_what_to_do() {
    let open: SocketAddr = ([0, 0, 0, 0], 8765).into();
    let refused =
        Foxglove::open(config(), Some(&open.into()), None).expect_err("others reach it").to_string();
    assert!(refused.contains("0.0.0.0:8765") && refused.contains("ssh -L 8765"), "{refused}");
    let first = Foxglove::open(config(), Some(&SocketAddr::from(LOOPBACK).into()), None).expect("it opens");
    let taken: SocketAddr = ([127, 0, 0, 1], first.port().expect("a port")).into();
    let refused = Foxglove::open(config(), Some(&taken.into()), None).expect_err("it is taken");
    assert!(matches!(&refused, Error::Listen(address, _) if *address == taken), "{refused}");
    let nowhere = Path::new("/no/such/folder/run.mcap");
    let refused = Foxglove::open(config(), None, Some(nowhere)).expect_err("no folder").to_string();
    assert!(refused.contains("/no/such/folder/run.mcap"), "{refused}");
}
