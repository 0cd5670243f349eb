//! One `.db3` file of rosbag2's sqlite3 storage, Humble's default.
//!
//! The database's tables are `topics`, `messages` and, since Iron, `message_definitions`. A bag of Humble contains no definitions; this project's own
//! definitions are used for known types. The file is opened read-only, and its contents (views, functions, lengths) are not trusted.

use std::{collections::BTreeMap, collections::VecDeque, path::Path, sync::Arc};

use rusqlite::{Connection, OpenFlags, config::DbConfig, limits::Limit};

use crate::{
    Topic, TopicKind,
    defect::Defect,
    definitions::{Channels, printable},
    fields,
    limits::Limits,
    qos,
    records::Damage,
    walk::Raw,
};

/// The first bytes of a database.
pub(crate) const MAGIC: &[u8] = b"SQLite format 3\0";

/// Number and total size of messages read from the database at once.
const BATCH: usize = 256;
const BATCH_BYTES: usize = 4 << 20;

/// Contents of a database.
pub(crate) struct Contents {
    pub(crate) channels: Channels,
    /// Number of topics omitted because of the memory limit.
    pub(crate) omitted: u64,
    /// Number of messages by channel.
    pub(crate) counts: BTreeMap<u16, u64>,
    /// Earliest and latest time, ns.
    pub(crate) span: Option<(i64, i64)>,
}

fn open(path: &Path, limits: &Limits) -> rusqlite::Result<Connection> {
    // Without a journal beside it nothing is written, not even for a moment.
    let mut journal = path.as_os_str().to_owned();
    journal.push("-wal");
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = match (path.to_str(), Path::new(&journal).exists()) {
        (Some(text), false) => {
            let escaped = text
                .replace('%', "%25")
                .replace('?', "%3f")
                .replace('#', "%23");
            let uri = format!("file:{escaped}?immutable=1");
            Connection::open_with_flags(uri, flags | OpenFlags::SQLITE_OPEN_URI)?
        }
        _ => Connection::open_with_flags(path, flags)?,
    };
    connection.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true)?;
    connection.set_db_config(DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false)?;
    connection.set_db_config(DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false)?;
    let longest = i32::try_from(limits.chunk).unwrap_or(i32::MAX);
    connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, longest)?;
    Ok(connection)
}

/// Finds out the contents of the database at `path`.
///
/// # Errors
/// The database is damaged or not a bag.
pub(crate) fn contents(path: &Path, limits: &Limits) -> rusqlite::Result<Contents> {
    let connection = open(path, limits)?;
    let definitions = definitions(&connection, limits).unwrap_or_default();
    let mut found = Contents {
        channels: Channels::new(),
        omitted: 0,
        counts: BTreeMap::new(),
        span: None,
    };
    let mut room = limits.definitions;
    let mut numbers = BTreeMap::new();
    // Before Foxy there were no QoS, before Iron no hashes.
    let mut statement = connection.prepare("SELECT * FROM topics ORDER BY id")?;
    let mut rows = statement.query(())?;
    let mut kinds: BTreeMap<(String, String), Arc<TopicKind>> = BTreeMap::new();
    while let Some(row) = rows.next()? {
        let text = |column: &str| {
            row.get::<_, Option<String>>(column)
                .map(Option::unwrap_or_default)
        };
        let of_later = |column: &str| text(column).unwrap_or_default();
        let (type_name, offers) = (text("type")?, of_later("offered_qos_profiles"));
        let key = (type_name.clone(), offers.clone());
        let kind = kinds.entry(key).or_insert_with(|| {
            let definition = definitions.get(&type_name).cloned();
            let recorded = of_later("type_description_hash");
            let (encoding, definition, hash) =
                definition.unwrap_or_else(|| known(&type_name, recorded));
            Arc::new(TopicKind {
                type_name: printable(&type_name),
                definition,
                definition_encoding: encoding,
                message_encoding: of_later("serialization_format"),
                type_hash: hash,
                offered_qos: qos::from_text(&offers),
            })
        });
        let topic = Topic {
            name: printable(&text("name")?),
            kind: Arc::clone(kind),
        };
        let size = topic.size() + topic.kind.size();
        match (u16::try_from(found.channels.len()), room.checked_sub(size)) {
            // Those behind an omitted one are omitted too: the kept are the first.
            (Ok(number), Some(left)) if found.omitted == 0 => {
                room = left;
                numbers.insert(row.get::<_, i64>("id")?, number);
                found.channels.insert(number, Arc::new(topic));
            }
            _ => found.omitted += 1,
        }
    }
    let mut statement = connection.prepare(
        "SELECT topic_id, COUNT(*), MIN(timestamp), MAX(timestamp) FROM messages GROUP BY topic_id",
    )?;
    let mut rows = statement.query(())?;
    while let Some(row) = rows.next()? {
        let Some(number) = numbers.get(&row.get::<_, i64>(0)?) else {
            continue;
        };
        let count = u64::try_from(row.get::<_, i64>(1)?).unwrap_or(0);
        found.counts.insert(*number, count);
        let (first, last) = (row.get::<_, i64>(2)?, row.get::<_, i64>(3)?);
        found.span = Some(match found.span {
            None => (first, last),
            Some((a, b)) => (a.min(first), b.max(last)),
        });
    }
    Ok(found)
}

fn text_of(row: &rusqlite::Row<'_>, at: usize) -> String {
    row.get(at).unwrap_or_default()
}

/// Definitions by type: encoding, text, hash.
type Definitions = BTreeMap<String, (String, String, String)>;

/// The definitions stored in the bag; an error if it has no such table.
fn definitions(connection: &Connection, limits: &Limits) -> rusqlite::Result<Definitions> {
    let mut statement = connection.prepare(
        "SELECT topic_type, encoding, encoded_message_definition, type_description_hash FROM message_definitions",
    )?;
    let mut rows = statement.query(())?;
    let mut found = Definitions::new();
    let mut room = limits.definitions;
    while let Some(row) = rows.next()? {
        let [name, encoding, text, hash] = [0, 1, 2, 3].map(|at| text_of(row, at));
        let size = name.len() + encoding.len() + text.len() + hash.len();
        let Some(left) = room.checked_sub(size as u64) else {
            break;
        };
        room = left;
        found.insert(name, (encoding, text, hash));
    }
    Ok(found)
}

/// Types whose definition differs between ROS distributions: without a hash only the messages show which one it is.
const OF_SEVERAL_VERSIONS: [&str; 1] = ["sensor_msgs/msg/Range"];

/// This project's definition of a type, if it has the recorded hash; otherwise empty.
fn known(type_name: &str, recorded: String) -> (String, String, String) {
    let is_its = |hash: &str| match recorded.is_empty() {
        true => !OF_SEVERAL_VERSIONS.contains(&type_name),
        false => recorded == hash,
    };
    match planesman_msgs::type_info(type_name).filter(|info| is_its(info.type_hash)) {
        Some(info) => {
            let texts = ["ros2msg", info.definition, info.type_hash];
            texts.map(str::to_owned).into()
        }
        None => (String::new(), String::new(), recorded),
    }
}

/// Stream of a database's messages, in the order in which they were written.
pub(crate) struct Rows {
    connection: Connection,
    channels: Arc<Channels>,
    /// Channels by the topic's id in the database.
    numbers: BTreeMap<i64, u16>,
    /// Id of the last message read.
    last: i64,
    batch: VecDeque<Row>,
    current: Row,
    /// Number of bytes read.
    bytes: u64,
    /// Number of messages read.
    pub(crate) met: u64,
}

#[derive(Default)]
struct Row {
    channel: u16,
    time: i64,
    payload: Vec<u8>,
}

impl Rows {
    /// The messages of the database at `path` with these topics.
    pub(crate) fn new(
        path: &Path,
        channels: Arc<Channels>,
        limits: &Limits,
    ) -> rusqlite::Result<Self> {
        let connection = open(path, limits)?;
        let mut statement = connection.prepare("SELECT id FROM topics ORDER BY id")?;
        let ids = statement.query_map((), |row| row.get::<_, i64>(0))?;
        let ids = ids.collect::<rusqlite::Result<Vec<_>>>()?;
        drop(statement);
        let kept = ids.into_iter().take(channels.len());
        Ok(Self {
            connection,
            numbers: kept.zip(0..=u16::MAX).collect(),
            channels,
            last: i64::MIN,
            batch: VecDeque::new(),
            current: Row::default(),
            bytes: 0,
            met: 0,
        })
    }

    /// Number of bytes read.
    pub(crate) fn offset(&self) -> u64 {
        self.bytes
    }

    /// The next message; `None` after the last one.
    pub(crate) fn next(&mut self) -> Result<Option<Raw<'_>>, Damage> {
        if self.batch.is_empty() {
            self.fill().map_err(|error| Damage {
                offset: self.bytes,
                reason: Defect::Unreadable(error.to_string()),
            })?;
        }
        let Some(row) = self.batch.pop_front() else {
            return Ok(None);
        };
        self.met += 1;
        self.current = row;
        let Row {
            channel,
            time,
            payload,
        } = &self.current;
        Ok(self.channels.get(channel).map(|topic| Raw {
            topic,
            message: fields::Message {
                channel_id: *channel,
                sequence: 0,
                log_time: *time,
                publish_time: *time,
                payload,
            },
        }))
    }

    /// Reads the next messages from the database.
    fn fill(&mut self) -> rusqlite::Result<()> {
        let mut statement = self.connection.prepare(
            "SELECT id, topic_id, timestamp, data FROM messages WHERE id > ?1 ORDER BY id",
        )?;
        let mut rows = statement.query([self.last])?;
        let mut bytes = 0;
        while self.batch.len() < BATCH && bytes < BATCH_BYTES {
            let Some(row) = rows.next()? else { break };
            self.last = row.get(0)?;
            let Some(channel) = self.numbers.get(&row.get(1)?) else {
                continue;
            };
            let payload: Vec<u8> = row.get(3)?;
            bytes += payload.len();
            self.batch.push_back(Row {
                channel: *channel,
                time: row.get(2)?,
                payload,
            });
        }
        self.bytes += bytes as u64;
        Ok(())
    }
}
