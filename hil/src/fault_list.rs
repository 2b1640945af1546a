//! The list of faults, and its spelling: `drop:0.02,tear@17` is two per cent of dropped frames and
//! a torn frame 17.

use core::fmt;
use core::str::FromStr;

/// Fault of a frame. All but [`FaultKind::Gap`] strike one payload of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// The payload never arrives.
    Drop,
    /// The payload is cut at a random place behind its header.
    Tear,
    /// The payload arrives 40 ms late, together with those of a later frame.
    Late,
    /// The frame identifier is wrong.
    Fid,
    /// The end-of-frame bit is missing.
    Eof,
    /// The error bit is set.
    Err,
    /// The header length says 0.
    Length0,
    /// The header length says 2, less than its flags need.
    Length2,
    /// The payload has fewer bytes than its header length of 200 says.
    Length200,
    /// The payload arrives twice.
    Duplicate,
    /// The camera skips one to five numbers in the counters of both streams.
    Gap,
    /// The frame comes in several payloads, each with a header; no fault, but not the rule.
    Split,
    /// No infrared payload for a depth payload.
    NoInfrared,
    /// The payload brings more pixels than the image has.
    Overlong,
    /// The payload has no byte.
    Empty,
}

/// All faults with their names.
const NAMES: [(&str, FaultKind); 15] = [
    ("drop", FaultKind::Drop),
    ("tear", FaultKind::Tear),
    ("late", FaultKind::Late),
    ("fid", FaultKind::Fid),
    ("eof", FaultKind::Eof),
    ("err", FaultKind::Err),
    ("length0", FaultKind::Length0),
    ("length2", FaultKind::Length2),
    ("length200", FaultKind::Length200),
    ("duplicate", FaultKind::Duplicate),
    ("gap", FaultKind::Gap),
    ("split", FaultKind::Split),
    ("noinfrared", FaultKind::NoInfrared),
    ("overlong", FaultKind::Overlong),
    ("empty", FaultKind::Empty),
];

impl FaultKind {
    /// Every fault, in the order of the documentation.
    pub fn all() -> impl Iterator<Item = Self> {
        NAMES.into_iter().map(|(_, kind)| kind)
    }

    /// Its name in a fault list.
    #[must_use]
    pub fn name(self) -> &'static str {
        NAMES.into_iter().find(|(_, kind)| *kind == self).map_or("", |(name, _)| name)
    }
}

/// When a fault strikes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// Each payload with this probability.
    Share(f64),
    /// The payloads of this shot, counted from 0.
    Shot(u64),
}

/// Faults, in the order in which they were written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaultList(pub Vec<(FaultKind, When)>);

/// Error of a text that is not a fault list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParseFaultError {
    /// An entry is neither `name:share` nor `name@shot`.
    Shape(String),
    /// No fault has this name.
    UnknownName(String),
    /// The share is not a number from 0 to 1.
    Share(String),
    /// The shot is not a whole number.
    Shot(String),
}

impl fmt::Display for ParseFaultError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape(entry) => {
                write!(f, "`{entry}` is no fault: write name:share (drop:0.02) or name@shot (tear@17)")
            }
            Self::UnknownName(name) => {
                let known: Vec<_> = NAMES.iter().map(|(name, _)| *name).collect();
                write!(f, "no fault is called `{name}`; there are {}", known.join(", "))
            }
            Self::Share(entry) => write!(f, "`{entry}`: the share must be a number from 0 to 1"),
            Self::Shot(entry) => write!(f, "`{entry}`: the shot must be a whole number, counted from 0"),
        }
    }
}

impl std::error::Error for ParseFaultError {}

impl FromStr for FaultList {
    type Err = ParseFaultError;

    fn from_str(text: &str) -> Result<Self, ParseFaultError> {
        let entries = text.split(',').map(str::trim).filter(|entry| !entry.is_empty());
        entries.map(parse_entry).collect::<Result<_, _>>().map(Self)
    }
}

fn parse_entry(entry: &str) -> Result<(FaultKind, When), ParseFaultError> {
    let split = entry.find([':', '@']).ok_or_else(|| ParseFaultError::Shape(entry.into()))?;
    let (name, value) = (&entry[..split], &entry[split + 1..]);
    let (_, kind) = NAMES
        .into_iter()
        .find(|(known, _)| *known == name)
        .ok_or_else(|| ParseFaultError::UnknownName(name.into()))?;
    let when = if entry[split..].starts_with(':') {
        let share = value.parse().ok().filter(|share| (0.0..=1.0).contains(share));
        When::Share(share.ok_or_else(|| ParseFaultError::Share(entry.into()))?)
    } else {
        When::Shot(value.parse().map_err(|_| ParseFaultError::Shot(entry.into()))?)
    };
    Ok((kind, when))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_reads_as_it_is_written() {
        let list: FaultList = "drop:0.02, tear@17,".parse().unwrap();
        assert_eq!(list.0, [(FaultKind::Drop, When::Share(0.02)), (FaultKind::Tear, When::Shot(17))]);
        assert_eq!("".parse(), Ok(FaultList::default()));
    }

    #[test]
    fn each_mistake_has_its_own_answer() {
        let table = [
            ("drop", ParseFaultError::Shape("drop".into())),
            ("drip:0.1", ParseFaultError::UnknownName("drip".into())),
            ("drop:1.5", ParseFaultError::Share("drop:1.5".into())),
            ("drop:x", ParseFaultError::Share("drop:x".into())),
            ("tear@-1", ParseFaultError::Shot("tear@-1".into())),
        ];
        for (text, error) in table {
            assert_eq!(text.parse::<FaultList>(), Err(error));
        }
    }

    #[test]
    fn every_fault_has_a_name_that_parses() {
        for kind in FaultKind::all() {
            let list: FaultList = format!("{}:1", kind.name()).parse().unwrap();
            assert_eq!(list.0, [(kind, When::Share(1.0))]);
        }
    }
}
