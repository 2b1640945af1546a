//! Recordings that are changed inside, with every length, offset and checksum around the change right again.

use crate::bytes::{read_recording, sound_recording};
use crate::mutation::{Edit, cases, edited, edits};
use crate::recordings;
use meniscus_data::recording::Recording;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::io::Read;
use std::path::Path;

/// Record of an MCAP file: opcode and body.
type McapRecord = (u8, Vec<u8>);

/// First and last bytes of an MCAP file.
const MCAP_MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";
/// Opcode of a chunk.
const MCAP_CHUNK: u8 = 6;

fn number(bytes: &[u8], at: usize) -> usize {
    u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes")) as usize
}

/// Records between the magics.
fn mcap_records(mut bytes: &[u8]) -> Vec<McapRecord> {
    let mut records = Vec::new();
    while bytes.len() >= 9 {
        let length = number(bytes, 1);
        records.push((bytes[0], bytes[9..9 + length].to_vec()));
        bytes = &bytes[9 + length..];
    }
    records
}

fn mcap_bytes(records: &[McapRecord]) -> Vec<u8> {
    let one =
        |(opcode, body): &McapRecord| [&[*opcode][..], &(body.len() as u64).to_le_bytes(), body].concat();
    records.iter().flat_map(one).collect()
}

/// Records in the body of a chunk, unpacked: times, size, CRC, compression, length, records (MCAP specification, op=0x06).
fn chunk_records(body: &[u8]) -> Vec<McapRecord> {
    let name = u32::from_le_bytes(body[28..32].try_into().expect("four bytes")) as usize;
    let packed = &body[32 + name + 8..];
    let mut unpacked = Vec::new();
    if name == 0 {
        unpacked.extend_from_slice(packed);
    } else {
        lz4_flex::frame::FrameDecoder::new(packed)
            .read_to_end(&mut unpacked)
            .expect("the writer's own chunk");
    }
    mcap_records(&unpacked)
}

/// A chunk of these records that is not compressed and states no CRC.
fn chunk_of(body: &[u8], records: &[McapRecord]) -> McapRecord {
    let inner = mcap_bytes(records);
    let size = (inner.len() as u64).to_le_bytes();
    (MCAP_CHUNK, [&body[..16], &size, &[0; 4], &[0; 4], &size, &inner].concat())
}

/// One change of a list of records.
#[derive(Clone, Debug)]
pub(crate) enum ListEdit {
    /// Changes within one.
    Body(usize, Vec<Edit>),
    /// Another kind of it.
    Kind(usize, u8),
    Drop(usize),
    Repeat(usize),
    Swap(usize, usize),
}

fn list_edit() -> impl Strategy<Value = ListEdit> {
    let place = || any::<usize>();
    prop_oneof![
        5 => (place(), edits()).prop_map(|(at, edits)| ListEdit::Body(at, edits)),
        1 => (place(), 0..16_u8).prop_map(|(at, kind)| ListEdit::Kind(at, kind)),
        1 => place().prop_map(ListEdit::Drop),
        1 => place().prop_map(ListEdit::Repeat),
        1 => (place(), place()).prop_map(|(a, b)| ListEdit::Swap(a, b)),
    ]
}

pub(crate) fn list_edits() -> impl Strategy<Value = Vec<ListEdit>> {
    prop::collection::vec(list_edit(), 1..4)
}

/// Carries out the changes on a list of `(kind, body)`; places count modulo its length.
pub(crate) fn relisted(mut list: Vec<McapRecord>, changes: &[ListEdit]) -> Vec<McapRecord> {
    for change in changes {
        if list.is_empty() {
            return list;
        }
        let length = list.len();
        match change {
            ListEdit::Body(at, edits) => list[at % length].1 = edited(&list[at % length].1, edits),
            ListEdit::Kind(at, kind) => list[at % length].0 = *kind,
            ListEdit::Drop(at) => drop(list.remove(at % length)),
            ListEdit::Repeat(at) => list.insert(at % length, list[at % length].clone()),
            ListEdit::Swap(a, b) => list.swap(a % length, b % length),
        }
    }
    list
}

/// A sound MCAP file with changes of its records, or of the records within its chunks.
pub(crate) fn mcap(sound: &[u8], changes: &[ListEdit], within: bool) -> Vec<u8> {
    let mut records = mcap_records(&sound[8..sound.len() - 8]);
    if within {
        for record in records.iter_mut().filter(|record| record.0 == MCAP_CHUNK) {
            let inner = relisted(chunk_records(&record.1), changes);
            *record = chunk_of(&record.1, &inner);
        }
    } else {
        records = relisted(records, changes);
    }
    [MCAP_MAGIC.as_slice(), &mcap_bytes(&records), MCAP_MAGIC].concat()
}

fn long(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize
}

/// Records of a ROS 1 bag: heads, then data, as two entries each (kind 0 and 1).
fn ros1_parts(mut bytes: &[u8]) -> Vec<McapRecord> {
    let mut parts = Vec::new();
    while bytes.len() >= 8 {
        let head = long(bytes, 0);
        let data = long(bytes, 4 + head);
        parts.push((0, bytes[4..4 + head].to_vec()));
        parts.push((1, bytes[8 + head..8 + head + data].to_vec()));
        bytes = &bytes[8 + head + data..];
    }
    parts
}

fn ros1_bytes(parts: &[McapRecord]) -> Vec<u8> {
    let part = |(_, body): &McapRecord| [&(body.len() as u32).to_le_bytes()[..], body].concat();
    parts.iter().flat_map(part).collect()
}

/// A sound plain bag with changes of its records, or within those of its `chunk`-th chunk, whose stated size is right again.
pub(crate) fn ros1(sound: &[u8], changes: &[ListEdit], chunk: Option<usize>) -> Vec<u8> {
    let (magic, rest) = sound.split_at(13);
    let mut parts = ros1_parts(rest);
    let size = |head: &[u8]| head.windows(5).position(|part| part == b"size=").map(|at| at + 5);
    let chunks: Vec<usize> = (0..parts.len()).step_by(2).filter(|at| size(&parts[*at].1).is_some()).collect();
    match chunk {
        None => parts = relisted(parts, changes),
        Some(which) => {
            let at = chunks[which % chunks.len()];
            parts[at + 1].1 = ros1_bytes(&relisted(ros1_parts(&parts[at + 1].1), changes));
            let (length, place) = (parts[at + 1].1.len() as u32, size(&parts[at].1).expect("a chunk"));
            parts[at].1[place..place + 4].copy_from_slice(&length.to_le_bytes());
        }
    }
    [magic, &ros1_bytes(&parts)].concat()
}

/// Statements that change a ROS 2 bag; `?1` is the changed message, `?2` a row.
const STATEMENTS: [&str; 12] = [
    "UPDATE messages SET data = ?1 WHERE id = ?2",
    "UPDATE messages SET data = NULL, topic_id = ?2 WHERE id = ?2 OR ?1 IS NULL",
    "UPDATE messages SET data = CAST(?1 AS TEXT) WHERE id = ?2",
    "UPDATE messages SET data = ?2, timestamp = -9223372036854775808 WHERE id = ?2 OR ?1 IS NULL",
    "UPDATE messages SET data = zeroblob(70000000) WHERE id = ?2 OR ?1 IS NULL",
    "UPDATE messages SET topic_id = ?2 % 9 - 1 WHERE ?1 IS NOT NULL",
    "UPDATE topics SET name = (SELECT name FROM topics WHERE id = ?2 % 7) WHERE id = 3 OR ?1 IS NULL",
    "UPDATE topics SET name = CAST(?1 AS TEXT) WHERE id = ?2 % 7",
    "UPDATE topics SET name = name || '/x' WHERE id = ?2 % 7 OR ?1 IS NULL",
    "DELETE FROM messages WHERE id = ?2 OR ?1 IS NULL",
    "DELETE FROM topics WHERE id = ?2 % 7 OR ?1 IS NULL",
    "INSERT INTO messages(id, topic_id, timestamp, data) VALUES (9223372036854775807 - ?2, ?2 % 7, 0, ?1)",
];

/// A ROS 2 bag of `pairs` images with the statements carried out; a statement that the database refuses changes nothing.
pub(crate) fn db3(path: &Path, statements: &[(usize, i64, Vec<Edit>)]) {
    recordings::db3(path, &recordings::images(2));
    let file = rusqlite::Connection::open(path).expect("a database");
    for (which, row, edits) in statements {
        let row = 1 + row.rem_euclid(11);
        let message: Vec<u8> = file
            .query_row("SELECT CAST(data AS BLOB) FROM messages WHERE id = ?1", [row], |found| {
                Ok(found.get::<_, Option<Vec<u8>>>(0)?.unwrap_or_default())
            })
            .unwrap_or_default();
        let _refused = file.execute(STATEMENTS[which % STATEMENTS.len()], (edited(&message, edits), row));
    }
}

/// Values that a field of a safetensors header may get.
fn hostile(which: usize) -> Value {
    let all = [
        json!(null),
        json!(-1),
        json!(0),
        json!(1),
        json!(u64::MAX),
        json!(1e300),
        json!([u64::MAX, 2]),
        json!([0, u64::MAX]),
        json!([]),
        json!("F64"),
        json!("I8"),
        json!("\u{1b}[2J"),
        json!("{\"radius_m\":-1}"),
        json!("[".repeat(2000)),
        json!({}),
    ];
    all[which % all.len()].clone()
}

/// The JSON header of the shipped recording with fields set to hostile values.
pub(crate) fn safetensors_header(changes: &[(usize, usize, usize)]) -> Vec<u8> {
    let sound = meniscus_shipped::RECORDING;
    let length = number(sound, 0);
    let mut header: Value = serde_json::from_slice(&sound[8..8 + length]).expect("JSON");
    for (tensor, field, value) in changes {
        let Some(tensors) = header.as_object_mut().filter(|all| !all.is_empty()) else { break };
        let name = tensors.keys().nth(tensor % tensors.len()).expect("a name").clone();
        match tensors.get_mut(&name).and_then(Value::as_object_mut).filter(|fields| !fields.is_empty()) {
            Some(fields) if field % 9 != 8 => {
                let inner = fields.keys().nth(field % fields.len()).expect("a field").clone();
                fields.insert(inner, hostile(*value));
            }
            _ if value.is_multiple_of(2) => drop(tensors.remove(&name)),
            _ => drop(tensors.insert(name, hostile(*value))),
        }
    }
    serde_json::to_vec(&header).expect("JSON")
}

/// A recording of the simulator with this header and the shipped tensors.
pub(crate) fn safetensors(header: &[u8]) -> Vec<u8> {
    let sound = meniscus_shipped::RECORDING;
    let tensors = &sound[8 + number(sound, 0)..];
    let padded = header.len().next_multiple_of(8);
    let spaces = vec![b' '; padded - header.len()];
    [&(padded as u64).to_le_bytes()[..], header, &spaces, tensors].concat()
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn mcap_structures(changes in list_edits(), within: bool) {
        read_recording("a.mcap", &mcap(&sound_recording("mcap"), &changes, within))?;
    }

    #[test]
    fn ros_1_structures(changes in list_edits(), chunk in prop::option::of(0..4_usize)) {
        read_recording("a.bag", &ros1(&sound_recording("plain"), &changes, chunk))?;
    }

    #[test]
    fn ros_2_structures(statements in prop::collection::vec((any::<usize>(), any::<i64>(), edits()), 1..4)) {
        let folder = recordings::scratch("fuzz-db3-structure");
        let path = folder.0.join("sound.db3");
        db3(&path, &statements);
        read_recording("a.db3", &std::fs::read(&path).expect("a database"))?;
    }

    #[test]
    fn safetensors_structures(changes in prop::collection::vec((any::<usize>(), any::<usize>(), any::<usize>()), 1..3)) {
        let bytes = safetensors(&safetensors_header(&changes));
        if let Ok(recording) = Recording::from_bytes(Path::new("mutated"), &bytes) {
            prop_assert!(recording.frames() > 0);
            prop_assert!(recording.profile_m.iter().all(|height| height.is_finite()));
        }
    }
}
