//! Attacks by ROS 2 bags, which are SQLite databases with a schema of their own.

use crate::meet::defused;

/// A ROS 2 bag cannot run a program of its own: views.
///
/// `messages` is a view that recurses for ever, or one that makes gigabytes.
#[test]
fn a_database_of_views() {
    for (name, view) in [
        (
            "recursion",
            "WITH RECURSIVE r(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r) SELECT n AS id, 1 AS topic_id, 'x' AS data FROM r WHERE n < 0",
        ),
        ("zeroblob", "SELECT 1 AS id, 1 AS topic_id, zeroblob(999999999) AS data"),
    ] {
        defused(name, "no plain tables", |folder| {
            let file = rusqlite::Connection::open(folder.join("bomb.db3")).expect("a database");
            file.execute_batch(&format!(
                "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT); CREATE VIEW messages AS {view};
                 INSERT INTO topics VALUES (1, '/device_0/sensor_0/Depth_0/camera_info');"
            ))
            .expect("a schema");
        });
    }
}

/// A ROS 2 bag cannot run a program of its own: computed columns.
///
/// A column that is computed from another one when it is read.
#[test]
fn a_database_of_computed_columns() {
    defused("computed.db3", "no plain tables", |folder| {
        let file = rusqlite::Connection::open(folder.join("bomb.db3")).expect("a database");
        file.execute_batch(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT);
             CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, data BLOB AS (zeroblob(900000000)));
             INSERT INTO topics VALUES (1, '/device_0/sensor_0/Depth_0/camera_info');
             INSERT INTO messages(topic_id) VALUES (1);",
        )
        .expect("a schema");
    });
}

/// A ROS 2 bag cannot stop the program by its names.
///
/// A column of the topics whose name is no UTF-8, which the library that reads SQLite answers with a panic.
#[test]
fn a_database_with_a_column_of_no_text() {
    defused("names.db3", "shorter than what it holds", |folder| {
        let path = folder.join("bomb.db3");
        let file = rusqlite::Connection::open(&path).expect("a database");
        file.execute_batch(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, no_text TEXT);
             CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, data BLOB);
             INSERT INTO topics VALUES (1, '/camera/depth', 'sensor_msgs/msg/Image', '');
             INSERT INTO messages VALUES (1, 1, x'00010000');",
        )
        .expect("a schema");
        drop(file);
        let mut bytes = std::fs::read(&path).expect("the file");
        let at = bytes.windows(7).position(|word| word == b"no_text").expect("the column");
        bytes[at..at + 7].fill(0xff);
        std::fs::write(&path, bytes).expect("written");
    });
}

/// A ROS 2 bag cannot exhaust time by rows of nothing, or by tables without an index.
///
/// A camera, then 400,000 rows of another topic; the same in a table whose `id` is no key, so that each row costs a scan.
#[test]
fn a_database_of_empty_rows() {
    for key in ["INTEGER PRIMARY KEY", "INTEGER"] {
        defused("rows.db3", "an image", |folder| {
            let file = rusqlite::Connection::open(folder.join("bomb.db3")).expect("a database");
            let camera = "width=64;height=48;fx=38.4;ppx=31.9;fy=38.5;ppy=23.6;";
            let message =
                [&[0, 1, 0, 0][..], &(camera.len() as u32 + 1).to_le_bytes(), camera.as_bytes(), &[0]]
                    .concat();
            file.execute_batch(&format!(
                "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT);
                 CREATE TABLE messages(id {key}, topic_id INTEGER, data BLOB);
                 INSERT INTO topics VALUES (1, '/device_0/sensor_0/Depth_0/camera_info'), (2, '/imu');"
            ))
            .expect("a schema");
            file.execute("INSERT INTO messages VALUES (0, 1, ?1)", [message]).expect("a camera");
            file.execute_batch(
                "WITH RECURSIVE r(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r WHERE n < 400000)
                 INSERT INTO messages SELECT n, 2, x'00010000' FROM r;",
            )
            .expect("rows");
        });
    }
}
