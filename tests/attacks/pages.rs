//! A live page and a Foxglove server beside a worker, and requests to them, for several classes of attacks.

use crate::support::{LOOPBACK, beside_turns, blob, connect_from};
use meniscus::blob::Model;
use meniscus::surface::{Config, Settings};
use meniscus_ui::foxglove::{Foxglove, Listen};
use meniscus_ui::page::Page;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use tungstenite::WebSocket;

fn config() -> Config {
    Config::new(Settings::default()).expect("sound")
}

/// An open page without a token, attacked beside a worker.
pub(crate) fn attack_page(attack: impl FnOnce(SocketAddr, &Page) + Send) {
    let bytes = blob();
    let model = Model::load(&bytes).expect("sound");
    let page = Page::open(&model, config(), "a test", LOOPBACK.into(), None).expect("it opens");
    let address = page.address();
    beside_turns(&page, || attack(address, &page));
}

/// An open Foxglove server, attacked beside a worker.
pub(crate) fn attack_foxglove(origins: &[&str], attack: impl FnOnce(SocketAddr) + Send) {
    let origins = origins.iter().map(|origin| (*origin).to_owned()).collect();
    let listen = Listen { address: LOOPBACK.into(), origins };
    let foxglove = Foxglove::open(config(), Some(&listen), None).expect("it opens");
    let address = SocketAddr::from(([127, 0, 0, 1], foxglove.port().expect("a server")));
    beside_turns(&foxglove, || attack(address));
}

/// The head of a request to change to a web socket, without `Host` and `Origin`.
pub(crate) fn upgrade(path: &str) -> String {
    format!(
        "GET {path} HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n"
    )
}

/// The status that a server answers an upgrade with; the connection is ended then.
pub(crate) fn status(address: SocketAddr, path: &str, headers: &str) -> u16 {
    let mut stream = connect_from(1, address);
    write!(stream, "{}{headers}\r\n", upgrade(path)).expect("sent");
    let mut first = [0; 12];
    stream.read_exact(&mut first).expect("an answer");
    String::from_utf8_lossy(&first[9..]).parse().expect("a status")
}

/// A viewer of the page from 127.0.0.`last`.
pub(crate) fn viewer(last: u8, address: SocketAddr) -> Result<WebSocket<TcpStream>, u16> {
    match tungstenite::client(format!("ws://{address}/live"), connect_from(last, address)) {
        Ok((socket, _)) => Ok(socket),
        Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(response))) => {
            Err(response.status().as_u16())
        }
        // A connection that ends without an answer.
        Err(_) => Err(0),
    }
}
