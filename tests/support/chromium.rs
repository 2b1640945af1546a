//! A headless Chromium with an empty profile, driven through its DevTools protocol.

use super::optional::skip;
use serde_json::{Value, json};
use std::fs;
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tungstenite::{Message, WebSocket};

/// Names under which systems install it.
const NAMES: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Time limit of anything on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// The browser; it ends with this value.
pub(crate) struct Browser {
    child: Child,
    profile: PathBuf,
    socket: WebSocket<TcpStream>,
    last: u64,
    /// Complaints of pages: errors that nobody caught, and what the browser logged as an error.
    pub(crate) complaints: Vec<String>,
}

/// One page in it.
#[derive(Clone)]
pub(crate) struct Tab(String);

impl Browser {
    /// Starts the browser; `None` where there is none, which fails in CI.
    pub(crate) fn start(name: &str) -> Option<Self> {
        let profile = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("chromium").join(name);
        let _old = fs::remove_dir_all(&profile);
        fs::create_dir_all(&profile).expect("a folder for the profile");
        let started = NAMES.iter().find_map(|program| {
            Command::new(program)
                .args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"])
                .args(["--disable-quic", "--no-first-run", "--disable-background-networking"])
                .args(["--disable-component-update", "--disable-sync", "--disable-dev-shm-usage"])
                .args(["--remote-debugging-port=0", "about:blank"])
                .arg(format!("--user-data-dir={}", profile.display()))
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .ok()
        });
        let Some(child) = started else {
            skip("there is no Chromium on this machine (apt-get install chromium)");
            return None;
        };
        // The port is in a file as soon as it listens: its first line the port, its second the path.
        let file = profile.join("DevToolsActivePort");
        let end = Instant::now() + PATIENCE;
        let (port, path) = loop {
            let text = fs::read_to_string(&file).unwrap_or_default();
            if let Some((port, path)) = text.trim().split_once('\n') {
                break (port.to_owned(), path.to_owned());
            }
            assert!(Instant::now() < end, "Chromium did not start");
            std::thread::sleep(Duration::from_millis(50));
        };
        let stream = TcpStream::connect(format!("127.0.0.1:{port}")).expect("it listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        let address = format!("ws://127.0.0.1:{port}{path}");
        let (socket, _) = tungstenite::client(address, stream).expect("its protocol");
        Some(Self { child, profile, socket, last: 0, complaints: vec![] })
    }

    /// The answer to one call.
    pub(crate) fn call(&mut self, tab: Option<&Tab>, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let mut call = json!({ "id": self.last, "method": method, "params": parameters });
        if let Some(Tab(session)) = tab {
            call["sessionId"] = json!(session);
        }
        self.socket.send(Message::text(call.to_string())).expect("sent");
        loop {
            let message = self.socket.read().expect("an answer in time");
            let Ok(text) = message.to_text() else { continue };
            let Ok(mut answer) = serde_json::from_str::<Value>(text) else { continue };
            match answer["method"].as_str() {
                Some("Runtime.exceptionThrown") => {
                    self.complaints.push(answer["params"]["exceptionDetails"].to_string());
                }
                Some("Log.entryAdded") if answer["params"]["entry"]["level"] == "error" => {
                    self.complaints.push(answer["params"]["entry"]["text"].to_string());
                }
                _ => {}
            }
            if answer["id"] == self.last {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].take();
            }
        }
    }

    /// A new page of this size at `url`.
    pub(crate) fn open(&mut self, url: &str, (width, height): (u32, u32)) -> Tab {
        let target = self.call(None, "Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = self.call(None, "Target.attachToTarget", attach);
        let tab = Tab(session["sessionId"].as_str().expect("a session").to_owned());
        let phone = width < 500;
        let metrics = json!({ "width": width, "height": height, "mobile": phone,
                              "deviceScaleFactor": if phone { 2 } else { 1 } });
        self.call(Some(&tab), "Emulation.setDeviceMetricsOverride", metrics);
        let dark = json!({ "features": [{ "name": "prefers-color-scheme", "value": "dark" }] });
        self.call(Some(&tab), "Emulation.setEmulatedMedia", dark);
        self.call(Some(&tab), "Runtime.enable", json!({}));
        self.call(Some(&tab), "Log.enable", json!({}));
        self.call(Some(&tab), "Page.navigate", json!({ "url": url }));
        tab
    }

    /// Returns the value of an expression on a page.
    pub(crate) fn evaluate(&mut self, tab: &Tab, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut answer = self.call(Some(tab), "Runtime.evaluate", parameters);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {}", answer["exceptionDetails"]);
        answer["result"]["value"].take()
    }

    /// Waits until an expression is true; on a page that is still loading it is not.
    pub(crate) fn until(&mut self, tab: &Tab, expression: &str) {
        let end = Instant::now() + PATIENCE;
        let careful = format!("(() => {{ try {{ return {expression} }} catch {{ return false }} }})()");
        while self.evaluate(tab, &careful) != true {
            if Instant::now() > end {
                let text = self.evaluate(tab, "document.body?.innerText ?? ''");
                panic!("never true: {expression}\n{}\n{:?}", text.as_str().unwrap_or(""), self.complaints);
            }
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    /// The element's picture as a person sees it, as PNG; the whole view for an empty selector.
    pub(crate) fn picture(&mut self, tab: &Tab, selector: &str) -> Vec<u8> {
        let mut parameters = json!({ "format": "png" });
        if !selector.is_empty() {
            let place = format!(
                "(() => {{ const b = document.querySelector('{selector}').getBoundingClientRect(); \
                 return {{ x: b.x + scrollX, y: b.y + scrollY, width: b.width, height: b.height, scale: 1 }} }})()"
            );
            parameters["clip"] = self.evaluate(tab, &place);
        }
        let answer = self.call(Some(tab), "Page.captureScreenshot", parameters);
        base64(answer["data"].as_str().expect("a picture"))
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _gone = self.child.kill();
        let _waited = self.child.wait();
        let _removed = fs::remove_dir_all(&self.profile);
    }
}

/// The bytes behind base64 (RFC 4648).
fn base64(text: &str) -> Vec<u8> {
    let value = |letter: u8| match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let (mut bytes, mut held, mut bits) = (Vec::with_capacity(text.len() * 3 / 4), 0_u32, 0);
    for letter in text.bytes().filter(|letter| *letter != b'=') {
        held = held << 6 | u32::from(value(letter));
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            bytes.push((held >> bits) as u8);
            held &= (1 << bits) - 1;
        }
    }
    bytes
}
