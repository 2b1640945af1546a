//! The program with its live page open, and those who knock there without a browser.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tungstenite::{Message, WebSocket};

/// A run with `--view`; it ends with this value.
pub(crate) struct Run {
    child: Child,
    /// The address that it printed.
    pub(crate) url: String,
}

impl Run {
    /// `meniscus run --view` with more `arguments`.
    pub(crate) fn start(arguments: &[&str]) -> Self {
        let out: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page");
        let mut child = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
            .args(["run", "--view", "--out"])
            .arg(&out)
            .args(arguments)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
        let url = lines.by_ref().map_while(Result::ok).find_map(|line| {
            eprintln!("{line}");
            line.strip_prefix("live page: ").map(str::to_owned)
        });
        // The rest is read, or the program would wait for room.
        std::thread::spawn(move || lines.map_while(Result::ok).for_each(|line| eprintln!("{line}")));
        let url = url.unwrap_or_else(|| {
            let _gone = child.kill();
            panic!("it printed no address")
        });
        Self { child, url }
    }

    /// Address and port.
    pub(crate) fn authority(&self) -> &str {
        self.url.trim_start_matches("http://").split('/').next().expect("an authority")
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        let _gone = self.child.kill();
        let _waited = self.child.wait();
    }
}

/// Status and body of a request to `address`; `head` is its first line and headers.
pub(crate) fn ask(address: SocketAddr, head: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(address).expect("it listens");
    stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
    // A server that refuses early may close before it has read everything.
    let _sent = stream.write_all(format!("{head}\r\n").as_bytes());
    let mut bytes = Vec::new();
    let _closed = stream.read_to_end(&mut bytes);
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let status = text.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
    (status, text.split_once("\r\n\r\n").map_or(String::new(), |(_, body)| body.to_owned()))
}

/// A viewer's socket at `path`, as a program without Origin opens it; the refusal's status otherwise.
pub(crate) fn viewer(address: SocketAddr, path: &str) -> Result<WebSocket<TcpStream>, u16> {
    let stream = TcpStream::connect(address).expect("it listens");
    stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
    match tungstenite::client(format!("ws://{address}{path}"), stream) {
        Ok((socket, _)) => Ok(socket),
        Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(response))) => {
            Err(response.status().as_u16())
        }
        Err(error) => panic!("{error}"),
    }
}

/// Says that frame `number` was taken and that `rate` are wanted a second.
pub(crate) fn taken(socket: &mut WebSocket<TcpStream>, number: u32, rate: u8) {
    let [a, b, c, d] = number.to_le_bytes();
    socket.send(Message::binary(vec![a, b, c, d, rate, 0, 0, 0])).expect("sent");
}

/// The next frame; images are skipped. `None` at the end.
pub(crate) fn frame(socket: &mut WebSocket<TcpStream>) -> Option<(u32, Vec<u8>)> {
    loop {
        match socket.read() {
            Ok(Message::Binary(bytes)) if bytes[0] == 1 => {
                let number = u32::from_le_bytes(bytes[4..8].try_into().expect("four bytes"));
                return Some((number, bytes.to_vec()));
            }
            Ok(Message::Close(_)) | Err(_) => return None,
            Ok(_) => {}
        }
    }
}
