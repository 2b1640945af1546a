//! One request: let in, or refused with words that say what to do.

use super::Token;
use super::assets::{ASSETS, Asset, INDEX};
use crate::listener::{HeadFault, Hosts, SenderFault, Senders, check_sender};
use tungstenite::handshake::server::Request;
use tungstenite::http::StatusCode;

/// Where the bases are.
const MODEL_PATH: &str = "/model";

/// Where the frames come from.
const LIVE_PATH: &str = "/live";

/// Where the figures of the newest turn are, for Prometheus.
const METRICS_PATH: &str = "/metrics";

/// Why a request is not answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// No head of this kind.
    Malformed,
    /// A head beyond the limit.
    TooLong,
    /// A head that did not come in time.
    Slow,
    /// No such path.
    NotFound,
    /// A name for this machine that a page of somebody else may have made up (DNS rebinding).
    Host,
    /// The token is wrong or missing.
    Token,
    /// A page of somebody else asks for the frames.
    Origin,
    /// Too many viewers.
    Full,
    /// Figures of a turn are requested, and none came.
    NoTurn,
}

impl Refusal {
    /// HTTP's word for it.
    pub(super) fn status(self) -> StatusCode {
        match self {
            Self::Malformed => StatusCode::BAD_REQUEST,
            Self::TooLong => StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE,
            Self::Slow => StatusCode::REQUEST_TIMEOUT,
            Self::NotFound => StatusCode::NOT_FOUND,
            Self::Host | Self::Token | Self::Origin => StatusCode::FORBIDDEN,
            Self::Full | Self::NoTurn => StatusCode::SERVICE_UNAVAILABLE,
        }
    }

    /// Returns the message of the refusal, with a remedy.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Malformed => "This is no request that the page knows. Open its address in a browser.",
            Self::TooLong => {
                "The request's head is longer than 8 KiB. Open the page in a private window, without cookies."
            }
            Self::Slow => "The request took longer than 5 seconds. Load the page again.",
            Self::NotFound => "There is nothing here. The page is at / of this address.",
            Self::Host => {
                "This name for the machine is not known here. Open the page by the address that the program \
                 printed, such as http://127.0.0.1:8060/."
            }
            Self::Token => {
                "The token in the address is wrong or missing. Open the page by the whole address that the program \
                 printed, with ?token= at its end; each start makes a new one unless --token-file is given."
            }
            Self::Origin => "Only the page itself may have the frames, not a page of another address.",
            Self::NoTurn => "No turn came for half a second. Look at the camera, and ask again.",
            Self::Full => "As many are looking as the page allows. Close a window and load the page again.",
        }
    }
}

/// Resource that a request names.
pub(super) enum Wanted {
    /// A file.
    File(Asset),
    /// The bases.
    Model,
    /// Frames, by this request to change to a web socket.
    Live(Request),
    /// Figures of the newest turn.
    Metrics,
}

impl From<HeadFault> for Refusal {
    fn from(fault: HeadFault) -> Self {
        match fault {
            HeadFault::Malformed => Self::Malformed,
            HeadFault::TooLong => Self::TooLong,
            HeadFault::Slow => Self::Slow,
        }
    }
}

impl From<SenderFault> for Refusal {
    fn from(fault: SenderFault) -> Self {
        match fault {
            SenderFault::Malformed => Self::Malformed,
            SenderFault::Host => Self::Host,
            SenderFault::Origin => Self::Origin,
        }
    }
}

/// Admission of requests, by token or by host name.
#[derive(Clone, Debug)]
pub(super) struct Gate {
    /// Without one, only this machine's own names are answered.
    pub(super) token: Option<Token>,
}

impl Gate {
    /// Returns the resource of `request`, or the reason for a refusal.
    pub(super) fn admit(&self, request: Request) -> Result<Wanted, Refusal> {
        let path = request.uri().path();
        let hosts = if self.token.is_none() { Hosts::ThisMachine } else { Hosts::Any };
        check_sender(&request, Senders { hosts, origins: &[] })?;
        // Style, scripts and the library are the same in every copy of the program: they are no secret.
        if let Some(asset) = ASSETS.iter().find(|asset| asset.path == path) {
            return Ok(Wanted::File(*asset));
        }
        if ![INDEX.path, MODEL_PATH, LIVE_PATH, METRICS_PATH].contains(&path) {
            return Err(Refusal::NotFound);
        }
        if let Some(token) = &self.token {
            let pairs = request.uri().query().unwrap_or_default().split('&');
            let given = pairs.filter_map(|pair| pair.strip_prefix("token=")).next();
            if !given.is_some_and(|given| token.admits(given)) {
                return Err(Refusal::Token);
            }
        }
        match path {
            MODEL_PATH => Ok(Wanted::Model),
            LIVE_PATH => Ok(Wanted::Live(request)),
            METRICS_PATH => Ok(Wanted::Metrics),
            _ => Ok(Wanted::File(INDEX)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::listener::read;

    fn answer(gate: &Gate, head: &str) -> Result<&'static str, Refusal> {
        gate.admit(read(&mut head.as_bytes())?.request).map(|wanted| match wanted {
            Wanted::File(asset) => asset.path,
            Wanted::Model => MODEL_PATH,
            Wanted::Live(_) => LIVE_PATH,
            Wanted::Metrics => METRICS_PATH,
        })
    }

    fn get(path: &str, host: &str, more: &str) -> String {
        format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n")
    }

    #[test]
    fn without_a_token_only_this_machines_names_are_answered() {
        let gate = Gate { token: None };
        for host in ["localhost:8060", "127.0.0.1:8060", "127.0.0.1", "[::1]:8060", "LOCALHOST:9"] {
            assert_eq!(answer(&gate, &get("/", host, "")), Ok("/"), "{host}");
        }
        for host in ["evil.example:8060", "127.0.0.1.evil.example", "10.0.0.5:8060", "localhost.evil:80", ""]
        {
            assert_eq!(answer(&gate, &get("/page.js", host, "")), Err(Refusal::Host), "{host}");
        }
        assert_eq!(answer(&gate, "GET / HTTP/1.1\r\n\r\n"), Err(Refusal::Malformed), "a head without a host");
        let two = get("/", "localhost", "Host: localhost\r\n");
        assert_eq!(answer(&gate, &two), Err(Refusal::Malformed), "a head with two hosts");
    }

    #[test]
    fn a_token_is_asked_for_by_all_but_the_files() {
        let gate = Gate { token: Some(Token::generate().expect("random")) };
        let token = gate.token.as_ref().expect("there").reveal().to_owned();
        for path in ["/", "/model", "/live", "/metrics"] {
            assert_eq!(answer(&gate, &get(path, "camera.lan", "")), Err(Refusal::Token));
            let wrong = format!("{path}?token={}x", &token[1..]);
            assert_eq!(answer(&gate, &get(&wrong, "camera.lan", "")), Err(Refusal::Token));
            let right = format!("{path}?a=b&token={token}");
            assert_eq!(answer(&gate, &get(&right, "camera.lan", "")), Ok(path));
        }
        assert_eq!(answer(&gate, &get("/page.js", "camera.lan", "")), Ok("/page.js"));
    }

    #[test]
    fn only_what_is_listed_is_there_and_only_the_page_gets_frames() {
        let gate = Gate { token: None };
        for path in ["/../Cargo.toml", "/assets/page.js", "/page.js/", "/etc/passwd", "//"] {
            assert_eq!(answer(&gate, &get(path, "localhost", "")), Err(Refusal::NotFound), "{path}");
        }
        let from = |origin: &str| get("/live", "localhost:8060", &format!("Origin: {origin}\r\n"));
        assert_eq!(answer(&gate, &from("http://localhost:8060")), Ok("/live"));
        for origin in ["http://evil.example", "foo://localhost:8060", "http://localhost:8061", "null"] {
            assert_eq!(answer(&gate, &from(origin)), Err(Refusal::Origin), "{origin}");
        }
    }

    #[test]
    fn heads_are_short_whole_and_only_read() {
        let gate = Gate { token: None };
        let long = get("/", "localhost", &format!("X: {}\r\n", "y".repeat(16 * 1024)));
        assert_eq!(answer(&gate, &long), Err(Refusal::TooLong));
        for broken in ["POST / HTTP/1.1\r\nHost: localhost\r\n\r\n", "GET / HT", "\u{1}\u{2}\r\n\r\n"] {
            assert_eq!(answer(&gate, broken), Err(Refusal::Malformed), "{broken}");
        }
    }
}
