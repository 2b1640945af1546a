//! The table of `meniscus bench`, as text, as JSON and as a page.

use meniscus::runtime::DEADLINE_US;
use meniscus_data::recording::GROUP_NAMES;
use meniscus_platform::cpu_features as wide;
use meniscus_report::checks::Check;
use meniscus_report::plot::PictureError;
use meniscus_report::{Chart, Mark, Report as Page, Series};
use meniscus_timing::bench::Times;
use meniscus_timing::bench::turn::Turns;
use serde_json::{Value, json};
use std::fmt::Write;

/// Targets: the chain over ONNX Runtime in the same run.
const OVER_ORT: [(&str, f64); 4] = [("f32", 0.75), ("bf16", 0.45), ("i8", 0.35), ("factored", 0.12)];

/// The variant whose last layers have the ranks of a model that was trained.
pub(super) const TRAINED: &str = "trained";

/// One variant of the chain.
#[derive(Debug, Default)]
pub(super) struct Variant {
    /// f32, bf16, i8, factored or [`TRAINED`].
    pub(super) name: &'static str,
    /// Bytes of weights that a call reads.
    pub(super) bytes: usize,
    /// Difference from f32 as a share of each group's range: root mean square, largest.
    pub(super) added: Option<[(f64, f64); 5]>,
    /// Its calls.
    pub(super) times: Times,
    /// Reading its weights once.
    pub(super) read: Times,
}

/// Everything measured.
#[derive(Debug, Default)]
pub(super) struct Report {
    /// The chain.
    pub(super) variants: Vec<Variant>,
    /// Rank and largest error, as a share of the range, of each factored group.
    pub(super) ranks: Vec<(usize, f64)>,
    /// Ranks of the groups in [`TRAINED`].
    pub(super) trained: [usize; 5],
    /// GRU and SPNN of the f32 chain alone.
    pub(super) parts: [Times; 2],
    /// Name, relative difference of the field from ours, calls.
    pub(super) peers: Vec<(String, f64, Times)>,
    /// Whole turns.
    pub(super) warm: Turns,
    /// Whole turns after the near caches were emptied.
    pub(super) cold: Turns,
    /// Resident memory in MiB, start to first estimate, the same less the window, s.
    pub(super) needs: Option<[f64; 3]>,
}

impl Report {
    /// The median of a peer's calls, NaN where it was not there.
    fn peer_us(&self, name: &str) -> f64 {
        self.peers.iter().find(|(peer, ..)| peer == name).map_or(f64::NAN, |(.., times)| times.median_us())
    }

    /// The checks, in the order of the table.
    pub(super) fn checks(&self) -> Vec<Check> {
        let mut checks = Vec::new();
        let ort = self.peer_us("ort");
        let over_ort = |name: &str| {
            let ours = self.variants.iter().find(|v| v.name == name);
            ours.map_or(f64::NAN, |v| v.times.median_us()) / ort
        };
        for (name, limit) in OVER_ORT {
            checks.push(Check::at_most(format!("chain_{name}_over_ort"), over_ort(name), "1", limit));
        }
        checks.push(Check::informational(format!("chain_{TRAINED}_over_ort"), over_ort(TRAINED), "1"));
        let factored = self.ranks.iter().map(|(_, error)| *error).fold(0.0, f64::max);
        checks.push(Check::at_most("factored_added_error", 100.0 * factored, "%", 0.5));
        let turn = &self.warm.whole;
        checks.push(Check::at_most("turn_us_median", turn.median_us(), "us", 800.0));
        checks.push(Check::informational("turn_cold_us_median", self.cold.whole.median_us(), "us"));
        checks.push(Check::at_most("p999_over_median", turn.quantile_us(0.999) / turn.median_us(), "1", 2.0));
        checks.push(Check::informational(
            "slowest_frame_over_median",
            self.warm.slowest_frame_us() / turn.median_us(),
            "1",
        ));
        let allocations = self.warm.allocations + self.cold.allocations;
        checks.push(Check::exactly("allocations", allocations as f64, "1", 0.0));
        let [resident, first, behind] = self.needs.unwrap_or([f64::NAN; 3]);
        checks.push(Check::at_most("rss_mib", resident, "MiB", 48.0));
        checks.push(Check::at_most("start_to_estimate_s", first, "s", 0.6));
        checks.push(Check::informational("start_behind_window_s", behind, "s"));
        checks
    }

    /// One HTML file.
    pub(super) fn html(&self, command: &str) -> Result<String, PictureError> {
        let mut page = Page::new("Times and sizes", command);
        page.prose("Window to field: the chain of networks in each format, and who else was asked, in the same rounds.");
        let timed = |times: &Times| [0.5, 0.95].map(|share| format!("{:.0}", times.quantile_us(share)));
        let own = self.variants.iter().map(|variant| {
            let [median, slow] = timed(&variant.times);
            vec![variant.name.into(), format!("{:.2}", variant.bytes as f64 * 1e-6), median, slow]
        });
        let others = self.peers.iter().map(|(name, _, times)| {
            let [median, slow] = timed(times);
            vec![name.clone(), "-".into(), median, slow]
        });
        page.table(&["", "MB of weights", "median, us", "95 %, us"], &own.chain(others).collect::<Vec<_>>());
        let curve = |turns: &Turns| -> Vec<(f64, f64)> {
            let at = |k: u32| (f64::from(k), turns.whole.quantile_us(0.01 * f64::from(k)));
            (0..100).map(at).collect()
        };
        let [warm, cold] = [&self.warm, &self.cold].map(curve);
        page.chart(&Chart {
            caption: "Whole turns, payload to field, in order of their length.",
            x: "turns that took no longer, %",
            y: "time of a turn, us",
            series: &[
                Series { name: "behind emptied caches", points: &cold, mark: Mark::Line, colour: 2 },
                Series { name: "one after another", points: &warm, mark: Mark::Line, colour: 1 },
            ],
        })?;
        page.checks(&self.checks());
        Ok(page.html())
    }

    /// One JSON object.
    pub(super) fn json(&self) -> Value {
        let times =
            |times: &Times| json!({ "median_us": times.median_us(), "p95_us": times.quantile_us(0.95) });
        let variants: Vec<Value> = self
            .variants
            .iter()
            .map(|v| {
                let added = v.added.map(|added| -> Value {
                    let groups = GROUP_NAMES.iter().zip(added);
                    groups.map(|(name, (rms, most))| ((*name).to_owned(), json!([rms, most]))).collect()
                });
                json!({ "name": v.name, "bytes": v.bytes, "times": times(&v.times), "read_once": times(&v.read), "added_rms_most": added })
            })
            .collect();
        let peers: Vec<Value> = self
            .peers
            .iter()
            .map(|(name, off, taken)| json!({ "name": name, "difference": off, "times": times(taken) }))
            .collect();
        json!({
            "command": "meniscus bench",
            "version": env!("CARGO_PKG_VERSION"),
            "machine": machine(),
            "vectors": wide::words(),
            "variants": variants,
            "gru": times(&self.parts[0]),
            "spnn": times(&self.parts[1]),
            "peers": peers,
            "ranks": self.ranks,
            "trained_ranks": self.trained,
            "stages_us_median": self.stages().into_iter().map(|(name, us, _)| (name.to_owned(), json!(us))).collect::<Value>(),
            "checks": self.checks(),
        })
    }

    /// Median of each stage warm and cold.
    fn stages(&self) -> [(&'static str, f64, f64); 5] {
        let of = |stage: fn(&meniscus::runtime::Stages) -> u64| {
            (self.warm.stage_us(stage), self.cold.stage_us(stage))
        };
        [
            ("surface", of(|s| s.surface_us)),
            ("predict", of(|s| s.predict_us)),
            ("encode", of(|s| s.encode_us)),
            ("correct", of(|s| s.correct_us)),
            ("field", of(|s| s.field_us)),
        ]
        .map(|(name, (warm, cold))| (name, warm, cold))
    }

    /// For a person.
    pub(super) fn text(&self) -> String {
        let mut text = format!("{}; vectors: {}\n", machine(), wide::words());
        let (ort, deadline) = (self.peer_us("ort"), DEADLINE_US as f64);
        let first = self.variants.first();
        let (bytes, read) = first.map_or((0, f64::NAN), |v| (v.bytes, v.read.median_us()));
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "window to field, paper-size networks; {:.1} MB of f32 read once in {read:.0} us: {:.1} GB/s\n",
            bytes as f64 / 1e6,
            bytes as f64 / read / 1e3
        );
        let _ = writeln!(
            text,
            "               us      95 %   over ort   over bound   of 16.67 ms   added, largest of a group"
        );
        for v in &self.variants {
            let us = v.times.median_us();
            let most = |added: [(f64, f64); 5]| added.iter().map(|(_, most)| *most).fold(0.0, f64::max);
            let added =
                v.added.map_or("-".into(), |added| format!("{:.3} % of the range", 100.0 * most(added)));
            let _ = writeln!(
                text,
                "{:10} {us:8.0}  {:8.0} {} {:12.2} {:11.1} %   {added}",
                v.name,
                v.times.quantile_us(0.95),
                ratio(us / ort),
                us / v.read.median_us(),
                100.0 * us / deadline
            );
        }
        for (name, off, times) in &self.peers {
            let us = times.median_us();
            let _ = writeln!(
                text,
                "{name:10} {us:8.0}  {:8.0} {} {:12.2} {:11.1} %   field differs by {off:.1e}",
                times.quantile_us(0.95),
                ratio(us / ort),
                us / read,
                100.0 * us / deadline
            );
        }
        if self.peers.is_empty() {
            let _ = writeln!(
                text,
                "no peers: the ratios to ONNX Runtime need --peers (meniscus bench --help says how)"
            );
        }
        let [gru, spnn] = &self.parts;
        let _ = writeln!(
            text,
            "of that GRU {:.0} us, SPNN with step {:.0} us",
            gru.median_us(),
            spnn.median_us()
        );
        let ranks: Vec<String> = GROUP_NAMES
            .iter()
            .zip(&self.ranks)
            .map(|(name, (rank, error))| format!("{name} {rank} ({:.2} %)", 100.0 * error))
            .collect();
        let _ = writeln!(text, "factored to rank (largest error of the range): {}", ranks.join(", "));
        let _ = writeln!(text, "ranks of the trained model: {:?}\n", self.trained);
        let stages: Vec<String> =
            self.stages().iter().map(|(name, warm, cold)| format!("{name} {warm:.0} / {cold:.0}")).collect();
        let _ = writeln!(text, "whole turn, stages in us, warm / cold caches: {}", stages.join(", "));
        text
    }
}

/// A ratio, or that there is none.
fn ratio(value: f64) -> String {
    if value.is_finite() { format!("{value:10.2}") } else { format!("{:>10}", "-") }
}

/// The processor, as the kernel names it.
fn machine() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = info
        .lines()
        .find_map(|line| line.strip_prefix("model name"))
        .unwrap_or(": a processor without a name");
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!("{}, {cores} cores", line.trim_start_matches([' ', '\t', ':']))
}
