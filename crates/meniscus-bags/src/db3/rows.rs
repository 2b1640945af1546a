//! Rows of a ROS 2 bag in SQLite, one by one.

use crate::BagError;
use crate::budget::{Budget, LONGEST, TIME};
use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::{Connection, OpenFlags, OptionalExtension};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Cost of a row at the least, bytes: each is a query of its own.
const ROW: u64 = 4096;

/// Steps of SQLite's machine between two looks at the clock.
const STEPS: i32 = 10_000;

/// A file of somebody else's, in which nothing runs but the queries here. Its schema is a program that the database would
/// follow: views may recurse for ever, and columns may be made up of what is not in the file.
pub(super) struct Database {
    pub(super) connection: Connection,
    /// Instant at which a query is interrupted, microseconds from `begun`.
    until_us: Arc<AtomicU64>,
    begun: Instant,
}

impl Database {
    /// Opens a file.
    pub(super) fn open(path: &Path) -> rusqlite::Result<Self> {
        let mut connection = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY)?;
        for (config, on) in [
            (DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false),
            (DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false),
            (DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER, false),
            (DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true),
        ] {
            connection.set_db_config(config, on)?;
        }
        for (limit, most) in [
            (Limit::SQLITE_LIMIT_LENGTH, LONGEST as i32),
            (Limit::SQLITE_LIMIT_SQL_LENGTH, 100_000),
            (Limit::SQLITE_LIMIT_COLUMN, 100),
            (Limit::SQLITE_LIMIT_ATTACHED, 0),
        ] {
            connection.set_limit(limit, most)?;
        }
        let (until_us, begun) = (Arc::new(AtomicU64::new(u64::MAX)), Instant::now());
        let until = Arc::clone(&until_us);
        let late = move || begun.elapsed().as_micros() as u64 > until.load(Ordering::Relaxed);
        connection.progress_handler(STEPS, Some(late))?;
        Ok(Self { connection, until_us, begun })
    }

    /// Gives queries `time` from now on.
    pub(super) fn allow(&self, time: Duration) {
        let until = self.begun.elapsed() + time;
        self.until_us.store(until.as_micros() as u64, Ordering::Relaxed);
    }

    /// Whether `messages` and `topics` are tables of the file itself: neither views nor virtual tables, which have no page,
    /// and without columns that are computed.
    pub(super) fn is_plain(&self) -> rusqlite::Result<bool> {
        let tables = "SELECT count(*) FROM sqlite_schema WHERE name IN ('messages', 'topics') AND type = 'table' \
                      AND rootpage > 0";
        let computed = "SELECT count(*) FROM pragma_table_xinfo(?1) WHERE hidden > 0";
        let count = |sql: &str, name: &[&str]| -> rusqlite::Result<i64> {
            self.connection.query_row(sql, rusqlite::params_from_iter(name), |row| row.get(0))
        };
        Ok(count(tables, &[])? == 2
            && count(computed, &["messages"])? == 0
            && count(computed, &["topics"])? == 0)
    }
}

/// Returns the message of an error of the database.
pub(super) fn explained(why: &rusqlite::Error) -> String {
    match why.sqlite_error_code() {
        Some(rusqlite::ErrorCode::OperationInterrupted) => {
            format!("it takes longer than {} s to find an image in it", TIME.as_secs())
        }
        Some(rusqlite::ErrorCode::TooBig) => {
            format!("a message in it is longer than {} MiB", LONGEST >> 20)
        }
        _ => why.to_string(),
    }
}

/// A message with its topic.
pub(super) struct Row {
    /// Number of the topic.
    pub(super) id: i64,
    /// Its name.
    pub(super) topic: String,
    /// Bytes of the message.
    pub(super) data: Vec<u8>,
}

/// Messages of a bag, one by one.
pub(super) struct Rows {
    path: PathBuf,
    pub(super) database: Database,
    /// The row that was read last.
    row: i64,
    /// Work until the next image.
    pub(super) budget: Budget,
    /// Images that were found, for errors.
    pub(super) images: u64,
}

impl Rows {
    /// Opens a bag whose tables are plain.
    pub(super) fn open(path: &Path) -> Result<Self, BagError> {
        let wrong = |why: String| BagError::Damaged { path: path.into(), why };
        let damaged = |why: rusqlite::Error| wrong(explained(&why));
        let database = Database::open(path).map_err(damaged)?;
        database.allow(TIME);
        if !database.is_plain().map_err(damaged)? {
            return Err(wrong("its messages and topics are no plain tables".into()));
        }
        Ok(Self { path: path.into(), database, row: i64::MIN, budget: Budget::new(), images: 0 })
    }

    /// Returns the error of a file that is damaged behind the images that were found.
    pub(super) fn damaged(&self, why: impl std::fmt::Display) -> BagError {
        BagError::Damaged { path: self.path.clone(), why: format!("{why}, behind {} images", self.images) }
    }

    /// The next message.
    pub(super) fn message(&mut self) -> Result<Option<Row>, BagError> {
        let sql = "SELECT messages.id, topics.id, topics.name, data FROM messages JOIN topics ON topics.id = topic_id \
                   WHERE messages.id > ?1 ORDER BY messages.id LIMIT 1";
        let begun = Instant::now();
        self.database.allow(self.budget.time_left());
        let read = self.database.connection.prepare_cached(sql).and_then(|mut statement| {
            let row = |row: &rusqlite::Row<'_>| Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?));
            statement.query_row([self.row], row).optional()
        });
        let found: Option<(i64, i64, String, Vec<u8>)> = read.map_err(|why| self.damaged(explained(&why)))?;
        let Some((row, id, topic, data)) = found else { return Ok(None) };
        self.budget.take(topic.len() + data.len(), ROW, begun).map_err(|why| self.damaged(why))?;
        // In a damaged file the rows may lead back.
        if row <= self.row {
            return Err(self.damaged("its rows are out of order"));
        }
        self.row = row;
        Ok(Some(Row { id, topic, data }))
    }
}
