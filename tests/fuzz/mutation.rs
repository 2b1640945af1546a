//! Changes of bytes, and the number of cases.

use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

/// One change of a row of bytes; places count modulo its length.
#[derive(Clone, Debug)]
pub(crate) enum Edit {
    Flip(usize, u8),
    Set(usize, u8),
    Word(usize, u32),
    Cut(usize),
    Insert(usize, u8),
    Remove(usize, usize),
    Repeat(usize, usize),
}

fn edit() -> impl Strategy<Value = Edit> {
    let place = || any::<usize>();
    // Numbers that lie at the borders of what lengths and counts can be.
    let word = prop_oneof![Just(0), Just(1), Just(u32::MAX), Just(u32::MAX / 2), Just(1 << 16), any::<u32>()];
    prop_oneof![
        4 => (place(), 0..8_u8).prop_map(|(at, bit)| Edit::Flip(at, 1 << bit)),
        4 => (place(), prop_oneof![Just(0), Just(1), Just(2), Just(255), any::<u8>()])
            .prop_map(|(at, value)| Edit::Set(at, value)),
        2 => (place(), word).prop_map(|(at, value)| Edit::Word(at, value)),
        1 => place().prop_map(Edit::Cut),
        1 => (place(), any::<u8>()).prop_map(|(at, value)| Edit::Insert(at, value)),
        1 => (place(), 1..64_usize).prop_map(|(at, count)| Edit::Remove(at, count)),
        1 => (place(), 1..64_usize).prop_map(|(at, count)| Edit::Repeat(at, count)),
    ]
}

/// Returns `sound` with the changes.
pub(crate) fn edited(sound: &[u8], edits: &[Edit]) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    for edit in edits {
        if bytes.is_empty() {
            return bytes;
        }
        let length = bytes.len();
        match *edit {
            Edit::Flip(at, bits) => bytes[at % length] ^= bits,
            Edit::Set(at, value) => bytes[at % length] = value,
            Edit::Word(at, value) => {
                bytes[at % length..].iter_mut().zip(value.to_le_bytes()).for_each(|(to, from)| *to = from);
            }
            Edit::Cut(at) => bytes.truncate(at % length),
            Edit::Insert(at, value) => bytes.insert(at % length, value),
            Edit::Remove(at, count) => drop(bytes.drain(at % length..(at % length + count).min(length))),
            Edit::Repeat(at, count) => {
                bytes.extend_from_within(at % length..(at % length + count).min(length));
            }
        }
    }
    bytes
}

/// Up to five changes.
pub(crate) fn edits() -> impl Strategy<Value = Vec<Edit>> {
    prop::collection::vec(edit(), 0..6)
}

/// Cases of a target: `usual`, times what `MENISCUS_FUZZ` says. A factor keeps the shares: a target whose case takes a
/// thousand times as long has fewer of them.
pub(crate) fn cases(usual: u32) -> ProptestConfig {
    let times = std::env::var("MENISCUS_FUZZ").map_or(1, |text| {
        text.parse().unwrap_or_else(|_| {
            panic!("MENISCUS_FUZZ={text}: expected a whole number, the times of the usual cases")
        })
    });
    let kept = FileFailurePersistence::WithSource("regressions");
    ProptestConfig {
        cases: usual.saturating_mul(times),
        failure_persistence: Some(Box::new(kept)),
        ..ProptestConfig::default()
    }
}
