//! The peers: a program of its own (`benches/peers`) that runs the same networks in ONNX Runtime, tract and candle,
//! and is asked line by line, so that their calls take turns with ours.
//!
//! ```text
//! > names                      < ort tract candle       those that work here; the others say why on standard error
//! > check NAME                 < relative difference of its field from ours
//! > time NAME COUNT            < COUNT times in nanoseconds
//! ```

use super::Times;
use std::io::{self, BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The peers' program at work; it ends with this.
#[derive(Debug)]
pub struct Peers {
    program: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl Peers {
    /// Starts `program` on the networks in `file`.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start(program: &Path, file: &Path) -> io::Result<Self> {
        // All on one thread, as we are.
        let mut child = Command::new(program)
            .arg(file)
            .envs([("RAYON_NUM_THREADS", "1"), ("OMP_NUM_THREADS", "1")])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let missing = || io::Error::other("the peers' program has no standard input or output");
        let input = child.stdin.take().ok_or_else(missing)?;
        let output = BufReader::new(child.stdout.take().ok_or_else(missing)?);
        Ok(Self { program: child, input, output })
    }

    /// One question and its answer.
    fn ask(&mut self, question: &str) -> io::Result<String> {
        writeln!(self.input, "{question}")?;
        self.input.flush()?;
        let mut answer = String::new();
        if self.output.read_line(&mut answer)? == 0 {
            return Err(io::Error::other("the peers' program ended; what it said stands above"));
        }
        Ok(answer.trim().to_string())
    }

    /// The peers that work here.
    ///
    /// # Errors
    /// When the program does not answer.
    pub fn names(&mut self) -> io::Result<Vec<String>> {
        Ok(self.ask("names")?.split_whitespace().map(ToString::to_string).collect())
    }

    /// |field - ours| / |ours| of a peer.
    ///
    /// # Errors
    /// When the program does not answer with a number.
    pub fn difference(&mut self, name: &str) -> io::Result<f64> {
        let answer = self.ask(&format!("check {name}"))?;
        answer.parse().map_err(|_| io::Error::other(format!("the peers' program answered '{answer}'")))
    }

    /// Adds `count` calls of a peer to `times`.
    ///
    /// # Errors
    /// When the program does not answer with as many numbers.
    pub fn take(&mut self, name: &str, count: usize, times: &mut Times) -> io::Result<()> {
        let answer = self.ask(&format!("time {name} {count}"))?;
        let taken: Vec<u64> = answer.split_whitespace().filter_map(|ns| ns.parse().ok()).collect();
        if taken.len() != count {
            return Err(io::Error::other(format!("the peers' program answered '{answer}'")));
        }
        times.0.extend(taken);
        Ok(())
    }
}

impl Drop for Peers {
    fn drop(&mut self) {
        // It ends when its input does; one that hangs is ended.
        let _gone = self.program.kill();
        let _waited = self.program.wait();
    }
}
