//! One datagram: `[TOKEN] [#NUMBER] ACCELERATION` in ASCII, apart by spaces.

use subtle::ConstantTimeEq;

/// Largest acceleration that is accepted, m/s2: twenty times gravity.
const LARGEST: f64 = 200.0;

/// Longest datagram, bytes.
pub(super) const LONGEST: usize = 256;

/// Content of a datagram that is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Datagram {
    /// Number of the sender, which rises.
    pub(super) number: Option<u64>,
    /// Acceleration along x, m/s2.
    pub(super) acceleration: f64,
}

impl Datagram {
    /// Datagram of a sender that numbers its samples elsewhere.
    pub(super) const WITHOUT_NUMBER: Self = Self { number: None, acceleration: 0.0 };
}

/// Reads `bytes`; `None` where they are no datagram, or lack the `token` that is wanted.
pub(super) fn read(bytes: &[u8], token: Option<&str>) -> Option<Datagram> {
    let mut words = std::str::from_utf8(bytes).ok()?.split_ascii_whitespace();
    if let Some(token) = token {
        let same: bool = words.next()?.as_bytes().ct_eq(token.as_bytes()).into();
        same.then_some(())?;
    }
    let mut word = words.next()?;
    let mut number = None;
    if let Some(digits) = word.strip_prefix('#') {
        number = Some(digits.parse().ok()?);
        word = words.next()?;
    }
    let acceleration: f64 = word.parse().ok()?;
    let whole = words.next().is_none() && acceleration.abs() <= LARGEST;
    whole.then_some(Datagram { number, acceleration })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_datagram_is_a_finite_number_in_range() {
        let plain = |acceleration| Some(Datagram { number: None, acceleration });
        assert_eq!(read(b" -1.25\n", None), plain(-1.25));
        assert_eq!(read(b"#17 2.5", None), Some(Datagram { number: Some(17), acceleration: 2.5 }));
        for wrong in
            [&b"nan"[..], b"inf", b"1e9", b"", b"1.0 2.0", b"#1", b"#-1 2", b"# 2", b"#1 #2 3", &[0xff, 0xfe]]
        {
            assert_eq!(read(wrong, None), None, "{wrong:?}");
        }
    }

    #[test]
    fn a_token_is_wanted_whole() {
        let token = Some("0123456789abcdef");
        let right = Some(Datagram { number: Some(1), acceleration: 2.0 });
        assert_eq!(read(b"0123456789abcdef #1 2.0", token), right);
        for wrong in [&b"2.0"[..], b"#1 2.0", b"0123456789abcdeX 2.0", b"0123456789abcde 2.0", b" 2.0"] {
            assert_eq!(read(wrong, token), None, "{wrong:?}");
        }
    }
}
