//! The paper's networks in ONNX Runtime, tract and candle, asked line by line by `meniscus bench --peers`.
//!
//! `meniscus-peers NETWORKS.safetensors` reads `names`, `check NAME` and `time NAME COUNT` from standard input and
//! answers each with one line. All run on one thread. A peer that does not work here says why on standard error.

mod candle;
mod graph;
mod networks;
mod onnx;
mod ort;
mod tract;

use anyhow::{Context, bail};
use networks::Networks;
use std::io::{BufRead, Write};
use std::time::Instant;

/// A library at work on the networks.
trait Peer {
    /// Runs window to field; the field is copied only into `keep`.
    fn run(&mut self, window: &[f32], keep: Option<&mut Vec<f32>>) -> anyhow::Result<()>;
}

fn main() -> anyhow::Result<()> {
    let path = std::env::args_os().nth(1).context("usage: meniscus-peers NETWORKS.safetensors")?;
    let file = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let networks = Networks::read(&file)?;
    let model = graph::model(&networks)?;
    let made: [(&'static str, anyhow::Result<Box<dyn Peer>>); 3] =
        [("ort", ort::peer(&model)), ("tract", tract::peer(&model)), ("candle", candle::peer(&networks))];
    let mut peers = Peers::new();
    for (name, peer) in made {
        match peer {
            Ok(peer) => peers.push((name, peer)),
            Err(error) => eprintln!("{name} is left out: {error:#}"),
        }
    }
    let (window, due) = (networks.numbers("window")?, networks.numbers("field")?);
    let mut output = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let answer = match words[..] {
            ["names"] => peers.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" "),
            ["check", name] => {
                let mut field = Vec::new();
                find(&mut peers, name)?.run(&window, Some(&mut field))?;
                difference(&field, &due)?.to_string()
            }
            ["time", name, count] => {
                let (peer, mut times) = (find(&mut peers, name)?, Vec::new());
                for _ in 0..count.parse::<usize>()? {
                    let start = Instant::now();
                    peer.run(&window, None)?;
                    times.push(start.elapsed().as_nanos().to_string());
                }
                times.join(" ")
            }
            _ => bail!("not a question: {line}"),
        };
        writeln!(output, "{answer}")?;
        output.flush()?;
    }
    Ok(())
}

/// Peers that work here, by name.
type Peers = Vec<(&'static str, Box<dyn Peer>)>;

/// The peer of that name.
fn find<'p>(peers: &'p mut Peers, wanted: &str) -> anyhow::Result<&'p mut Box<dyn Peer>> {
    let found = peers.iter_mut().find(|(name, _)| *name == wanted);
    found.map(|(_, peer)| peer).with_context(|| format!("no peer '{wanted}'"))
}

/// |field - due| / |due|.
fn difference(field: &[f32], due: &[f32]) -> anyhow::Result<f64> {
    anyhow::ensure!(field.len() == due.len(), "{} numbers came out, {} are due", field.len(), due.len());
    let square = |x: f32| f64::from(x) * f64::from(x);
    let off: f64 = field.iter().zip(due).map(|(a, b)| square(a - b)).sum();
    Ok((off / due.iter().map(|x| square(*x)).sum::<f64>()).sqrt())
}
