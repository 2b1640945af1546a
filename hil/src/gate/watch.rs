//! The emulator as a child: its lines are kept as they come, with the wall time of each scenario.

use super::Failure;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Runs `command` for at most `seconds`. `false` when it ended badly or its time was up.
pub(crate) fn run(log: &str, seconds: &str, command: &[&str]) -> Result<bool, Failure> {
    let limit = Duration::from_secs(seconds.parse().map_err(|_| format!("{seconds}: no number of seconds"))?);
    let (path, begun) = (Path::new(log), Instant::now());
    let (mut kept, mut times) = (File::create(path)?, File::create(path.with_extension("times"))?);
    let (mut child, output) = started(command)?;
    let (to, lines) = channel();
    let reader = std::thread::spawn(move || {
        for line in BufReader::new(output).split(b'\n').map_while(Result::ok) {
            if to.send(line).is_err() {
                return;
            }
        }
    });
    let mut last = begun;
    let in_time = loop {
        match lines.recv_timeout(limit.saturating_sub(begun.elapsed())) {
            Ok(line) => {
                let text = String::from_utf8_lossy(&line);
                let text = text.trim_end_matches('\r');
                writeln!(kept, "{text}")?;
                if text.contains("HIL {") {
                    writeln!(times, "{:.1}", last.elapsed().as_secs_f64())?;
                    last = Instant::now();
                }
            }
            Err(RecvTimeoutError::Disconnected) => break true,
            Err(RecvTimeoutError::Timeout) => break false,
        }
    };
    if !in_time {
        eprintln!("the guest did not end within {seconds} s; its log is {log}");
        child.kill()?;
    }
    let status = child.wait()?;
    let _joined = reader.join();
    Ok(in_time && status.success())
}

/// `command` as a child, and what it prints.
pub(super) fn started(command: &[&str]) -> Result<(Child, ChildStdout), Failure> {
    let (program, arguments) = command.split_first().ok_or("no command")?;
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|error| format!("{program} cannot be started: {error}"))?;
    let output = child.stdout.take().ok_or("no output")?;
    Ok((child, output))
}
