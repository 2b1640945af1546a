//! `meniscus bench`: the kernels against their peers and their bound, the turn, and what a runtime needs.

mod report;
mod work;

use super::inputs::file;
use super::stop::watched;
use anyhow::{Context, ensure};
use indicatif::ProgressBar;
use meniscus::blob::Model;
use meniscus::latent::nn::Element;
use meniscus::surface::Settings;
use meniscus_data::recording::Recording;
use meniscus_platform::files::{check_writable, write_whole};
use meniscus_report::checks::table;
use meniscus_timing::bench::chain::{Chain, Packed};
use meniscus_timing::bench::factor::{factored, of_ranks};
use meniscus_timing::bench::networks::{Layer, Networks};
use meniscus_timing::bench::peers::Peers;
use meniscus_timing::bench::runtime::{paper_size, payload_file, serve};
use meniscus_timing::bench::turn::{Caches, Passes, Payloads, payloads, turns};
use meniscus_timing::bench::{Times, differences, read_once};
use meniscus_virtual::render::SceneSettings;
use report::{Report, TRAINED, Variant};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Largest error that the factored decoder may add, as a share of a group's range.
const BUDGET: f64 = 0.005;

/// Calls of each party in a round.
const CALLS: usize = 10;

/// Frames of the recording that the turn is timed on.
const FRAMES: usize = 120;

/// Time the kernels, the turn and a start beside named peers.
///
/// Networks of a published size (GRU 3 x 26 over 16 x 42, SPNN of 13 layers of 195, five decoders to 27742 numbers) with random
/// weights go from window to full field on one thread: in f32, bf16 and i8, and with factored last layers, once of the ranks that
/// random weights need and once of those of --model (its time alone). The bound is the time to read the weights once. Calls of all
/// parties alternate, so a ratio is more reliable than a time.
///
/// The peers (ONNX Runtime, tract, candle) are a program of their own, which takes minutes to build. Without --peers the ratios
/// are not measured.
///
/// The turn is that of the worker, payload to field, with warm and emptied caches.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  meniscus bench\n  meniscus bench --json\n  meniscus bench --model small.blob --rounds 10",
    after_long_help = "The peers are built and used so:\n  benches/peers/fetch\n  cargo build --release --manifest-path benches/peers/Cargo.toml\n  ORT_DYLIB_PATH=... meniscus bench --peers PROGRAM\nfetch prints the last line as it is on this machine."
)]
pub(crate) struct Arguments {
    /// Model that the turn is timed with: shipped or a blob.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE", help_heading = "Method")]
    model: String,
    /// The peers' program.
    #[arg(long, value_name = "PROGRAM", help_heading = "Method")]
    peers: Option<PathBuf>,
    /// Rounds of ten calls of every party, 1 to 10000.
    #[arg(long, default_value_t = 30, help_heading = "Method")]
    rounds: usize,
    /// Seed of the networks' weights.
    #[arg(long, default_value_t = 1, help_heading = "Method")]
    seed: u64,
    /// Only do the fixed work of every stage this many times.
    ///
    /// Without any clock, for counting instructions (benches/instructions).
    #[arg(long, value_name = "TIMES", conflicts_with_all = ["peers", "json", "report"], help_heading = "Method")]
    count: Option<u32>,
    /// Also write the report as one HTML file.
    #[arg(long, value_name = "FILE.html", help_heading = "Output")]
    report: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Used by the command itself: serve a blob file on a payload file, in a process of its own.
    #[arg(long, hide = true, num_args = 2, value_names = ["BLOB", "PAYLOADS"])]
    serve: Option<Vec<PathBuf>>,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    if let Some([blob, payloads]) = arguments.serve.as_deref() {
        let needs = serve(blob, payloads, started)?;
        println!("{} {} {}", needs.resident_mib, needs.first_estimate_s, needs.behind_window_s);
        return Ok(());
    }
    ensure!(
        (1..=10_000).contains(&arguments.rounds),
        "--rounds {} is out of range: 1 to 10000",
        arguments.rounds
    );
    arguments.report.as_deref().map_or(Ok(()), check_writable)?;
    let bytes = file(&arguments.model)?;
    let model = Model::load(&bytes).with_context(|| format!("the model {} is refused", arguments.model))?;
    let recording = Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?;
    let header = &model.header;
    let settings = Settings::for_glass(header.radius_m, header.fill_m, header.rim_m);
    if let Some(times) = arguments.count {
        return work::count(&model, &recording, settings, times);
    }
    let stop = watched()?;
    let bar = if arguments.json { ProgressBar::hidden() } else { crate::bars::bar(1000) };
    bar.set_style(crate::bars::style("{msg:36} {wide_bar} {percent} %, {left}")?);
    bar.enable_steady_tick(Duration::from_millis(200));
    let mut report = Report::default();
    let ranks = model.decoder.groups.map(|group| group.basis.columns());
    chains(arguments, ranks, &bar, stop, &mut report)?;

    bar.set_message("the camera's payloads");
    let scene = SceneSettings { camera: settings, ..SceneSettings::default() };
    let frames = payloads(&recording, scene, FRAMES);
    bar.set_message("whole turns");
    report.warm = turns(&model, settings, &frames, Passes { count: 25, caches: Caches::Warm }, stop)?;
    bar.set_position(850);
    report.cold = turns(&model, settings, &frames, Passes { count: 2, caches: Caches::Cold }, stop)?;
    bar.set_message("a start with a paper-size blob");
    bar.set_position(950);
    if !stop.load(Ordering::Relaxed) {
        report.needs = Some(needs(&frames)?);
    }
    bar.finish_and_clear();
    ensure!(!stop.load(Ordering::Relaxed), "stopped before everything was measured: no table");
    if let Some(path) = &arguments.report {
        let command = format!("meniscus bench --rounds {} --seed {}", arguments.rounds, arguments.seed);
        write_whole(path, report.html(&command)?.as_bytes())?;
    }
    if arguments.json {
        println!("{:#}", report.json());
    } else {
        print!("{}{}", report.text(), table(&report.checks()));
    }
    Ok(())
}

/// In what a layer of the chain goes when the weights go in `to`: the SPNN stands for energy and operators, which stay
/// f32, the GRU is never below bf16.
fn element(to: Element, layer: &Layer) -> Element {
    match layer.name.split('.').next() {
        Some("spnn" | "head") => Element::F32,
        Some("gru") if to == Element::I8 => Element::Bf16,
        _ => to,
    }
}

/// The chain in every variant, the bound and the peers, taking turns. `trained`: the ranks of a model that was trained.
fn chains(
    arguments: &Arguments,
    trained: [usize; 5],
    bar: &ProgressBar,
    stop: &AtomicBool,
    report: &mut Report,
) -> anyhow::Result<()> {
    bar.set_message("networks by a seed");
    let networks = Networks::new(arguments.seed);
    let plain = Packed::new(&networks, |layer| element(Element::F32, layer));
    let half = Packed::new(&networks, |layer| element(Element::Bf16, layer));
    let byte = Packed::new(&networks, |layer| element(Element::I8, layer));
    let fits = "the networks have not the chain's shape";
    let chain = plain.chain().context(fits)?;
    bar.set_message("factoring the last layers");
    let (cut, ranks) = factored(&networks, &chain, BUDGET);
    let cut = Packed::new(&cut, |layer| element(Element::F32, layer));
    let ranked = of_ranks(&networks, trained);
    let ranked = Packed::new(&ranked, |layer| element(Element::F32, layer));
    let window = Networks::window(1000);
    let mut field = Chain::field();
    chain.run(&window, &mut field);
    let due = field.clone();
    let mut variants = Vec::new();
    for (name, packed) in [("f32", &plain), ("bf16", &half), ("i8", &byte), ("factored", &cut)] {
        let chain = packed.chain().context(fits)?;
        chain.run(&window, &mut field);
        let added = Some(differences(&due, &field));
        variants.push((Variant { name, bytes: packed.bytes(), added, ..Variant::default() }, packed, chain));
    }
    // Its weights are made up, so there is nothing to compare its field with.
    let variant = Variant { name: TRAINED, bytes: ranked.bytes(), ..Variant::default() };
    variants.push((variant, &ranked, ranked.chain().context(fits)?));

    let mut peers = Vec::new();
    let folder = std::env::temp_dir().join(format!("meniscus-bench-{}", std::process::id()));
    let mut program = match &arguments.peers {
        None => None,
        Some(program) => {
            bar.set_message("starting the peers");
            let path = folder.join("networks.safetensors");
            write_whole(&path, &networks.file(&window, &due)?)?;
            let mut program = Peers::start(program, &path)
                .with_context(|| format!("the peers' program {} does not start", program.display()))?;
            for name in program.names()? {
                let difference = program.difference(&name)?;
                peers.push((name, difference, Times::default()));
            }
            Some(program)
        }
    };
    bar.set_message("window to field");
    for round in 0..arguments.rounds {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        for (variant, packed, chain) in &mut variants {
            variant.times.take(CALLS, || chain.run(black_box(&window), &mut field));
            variant.read.take(CALLS, || {
                black_box(read_once(packed.memory()));
            });
        }
        let parts = &mut report.parts;
        parts[0].take(CALLS, || {
            black_box(chain.encode(black_box(&window)));
        });
        let x = chain.encode(&window);
        parts[1].take(CALLS, || {
            black_box(chain.step(black_box(&x)));
        });
        if let Some(program) = &mut program {
            for (name, _, times) in &mut peers {
                program.take(name, CALLS, times)?;
            }
        }
        bar.set_position((800 * (round + 1) / arguments.rounds) as u64);
    }
    drop(program);
    // What cannot be removed from the folder for temporary files, the system removes.
    let _left = std::fs::remove_dir_all(&folder);
    report.variants = variants.into_iter().map(|(variant, ..)| variant).collect();
    report.peers = peers;
    report.ranks = ranks;
    report.trained = trained;
    Ok(())
}

/// Memory and start of a runtime with a paper-size blob, in a process of its own.
fn needs(frames: &Payloads) -> anyhow::Result<[f64; 3]> {
    let folder = std::env::temp_dir().join(format!("meniscus-bench-serve-{}", std::process::id()));
    let (blob, payloads) = (folder.join("paper.blob"), folder.join("payloads"));
    write_whole(&blob, &paper_size(&file("shipped")?)?)?;
    write_whole(&payloads, &payload_file(&frames[..frames.len().min(60)].to_vec()))?;
    let program = std::env::current_exe().context("this program does not know its own file")?;
    let answer = Command::new(program).args(["bench", "--serve"]).args([&blob, &payloads]).output()?;
    let _left = std::fs::remove_dir_all(&folder);
    let text = String::from_utf8_lossy(&answer.stdout);
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [resident, first, behind] = numbers[..] else {
        anyhow::bail!("the runtime gave no estimate: {}", String::from_utf8_lossy(&answer.stderr).trim());
    };
    Ok([resident, first, behind])
}
