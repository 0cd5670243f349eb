//! `metadata.yaml`: rosbag2's description of a bag, written when the bag is closed.
//!
//! The fields and their order are rosbag2's `BagMetadata`, version 9 (Jazzy). Versions 1 to 8
//! lack some of them or write the QoS as text; both are read. A bag without this file was not
//! closed.

use std::{
    collections::BTreeMap,
    fs,
    io::{self, Read as _},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Deserializer, Serialize};

use planesman_text::{write_text, yaml};

use crate::OfferedQos;

/// The file's name in the bag's folder.
pub const FILE_NAME: &str = "metadata.yaml";

/// The version that is written.
pub const VERSION: u32 = 9;

/// The longest account read, bytes: that of six thousand topics. YAML takes up to seventy times its text while it is read.
const LONGEST: u64 = 4 << 20;

/// `starting_time` of a bag without messages, as rosbag2 writes it.
pub(crate) const NEVER: i64 = i64::MAX;

/// The prefix of a topic's name in the key of its number of lost messages.
pub(crate) const DROPPED: &str = "dropped ";

/// A bag's account.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BagMetadata {
    /// The version of this account.
    pub version: u32,
    /// The storage: `mcap`.
    pub storage_identifier: String,
    /// From the first message to the last.
    pub duration: Duration,
    /// When the first message came.
    pub starting_time: StartingTime,
    /// Messages in all files.
    pub message_count: u64,
    /// Every topic, with its messages in all files.
    pub topics_with_message_count: Vec<TopicWithCount>,
    /// The compressor of whole files or single messages; empty for none. MCAP compresses its
    /// chunks itself, which is not recorded here.
    #[serde(default)]
    pub compression_format: String,
    /// `file`, `message`, or empty for none.
    #[serde(default)]
    pub compression_mode: String,
    /// The files, in order.
    pub relative_file_paths: Vec<String>,
    /// The files, in order, with their times.
    #[serde(default)]
    pub files: Vec<FileInformation>,
    /// Whatever the recorder adds, as text.
    #[serde(default)]
    pub custom_data: Option<BTreeMap<String, String>>,
    /// The ROS distribution whose conventions the bag follows.
    #[serde(default)]
    pub ros_distro: String,
}

/// A span of time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Duration {
    /// Nanoseconds.
    pub nanoseconds: i64,
}

/// A moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct StartingTime {
    /// Nanoseconds since the epoch of the clock recorded by.
    pub nanoseconds_since_epoch: i64,
}

/// A topic and its messages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TopicWithCount {
    /// The topic.
    pub topic_metadata: TopicMetadata,
    /// Its messages in all files.
    pub message_count: u64,
}

/// A topic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TopicMetadata {
    /// The full name.
    pub name: String,
    /// The ROS type.
    #[serde(rename = "type")]
    pub type_name: String,
    /// How payloads are encoded: `cdr`.
    #[serde(default)]
    pub serialization_format: String,
    /// The QoS that the publishers offered; none when read from a version with another format.
    #[serde(default, deserialize_with = "offers_or_none")]
    pub offered_qos_profiles: Vec<OfferedQos>,
    /// The type hash.
    #[serde(default)]
    pub type_description_hash: String,
}

/// One file of the bag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileInformation {
    /// Its name in the bag's folder.
    pub path: String,
    /// When its first message came.
    pub starting_time: StartingTime,
    /// From its first message to its last.
    pub duration: Duration,
    /// Its messages.
    pub message_count: u64,
}

/// The file's one key.
#[derive(Serialize, Deserialize)]
struct Document {
    rosbag2_bagfile_information: BagMetadata,
}

fn offers_or_none<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<OfferedQos>, D::Error> {
    let value = serde_yaml_ng::Value::deserialize(deserializer)?;
    Ok(serde_yaml_ng::from_value(value).unwrap_or_default())
}

/// Why `metadata.yaml` could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum MetadataError {
    /// The file system refused.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// Longer than any account.
    #[error("{path} has {length} bytes; at most {LONGEST} are read")]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Its bytes.
        length: u64,
    },
    /// The text is not a bag's account.
    #[error("{path} is not the metadata of a rosbag2 bag: {source}")]
    Format {
        /// The file.
        path: PathBuf,
        /// The reason and the place.
        source: yaml::Error,
    },
}

impl BagMetadata {
    /// The account of a bag that has no file and no message yet.
    pub(crate) fn empty() -> Self {
        Self {
            version: VERSION,
            storage_identifier: "mcap".to_owned(),
            duration: Duration::default(),
            starting_time: StartingTime {
                nanoseconds_since_epoch: NEVER,
            },
            message_count: 0,
            topics_with_message_count: Vec::new(),
            compression_format: String::new(),
            compression_mode: String::new(),
            relative_file_paths: Vec::new(),
            files: Vec::new(),
            custom_data: None,
            ros_distro: "jazzy".to_owned(),
        }
    }

    /// Messages known to be lost, which this crate's writer keeps in
    /// [`custom_data`](Self::custom_data) under `dropped TOPIC`.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped_by_topic()
            .fold(0, |sum, (_, count)| sum.saturating_add(count))
    }

    /// The topics of which messages are known to be lost, and how many.
    pub fn dropped_by_topic(&self) -> impl Iterator<Item = (&str, u64)> {
        self.custom_data
            .iter()
            .flatten()
            .filter_map(|(key, count)| Some((key.strip_prefix(DROPPED)?, count.parse().ok()?)))
    }

    /// Reads the account at `path`.
    ///
    /// # Errors
    /// When the file cannot be read, has more than 4 MiB, or is not an account.
    pub fn read(path: &Path) -> Result<Self, MetadataError> {
        let unreadable = |source| MetadataError::Io {
            path: path.to_owned(),
            source,
        };
        // Asked before it is opened: a pipe would be waited for.
        let about = fs::metadata(path).map_err(unreadable)?;
        if !about.is_file() {
            return Err(unreadable(io::Error::other("it is not a regular file")));
        }
        if about.len() > LONGEST {
            return Err(MetadataError::TooLong {
                path: path.to_owned(),
                length: about.len(),
            });
        }
        let mut text = String::new();
        fs::File::open(path)
            .and_then(|file| file.take(LONGEST).read_to_string(&mut text))
            .map_err(unreadable)?;
        let document: Document = yaml::from_str(&text).map_err(|source| MetadataError::Format {
            path: path.to_owned(),
            source,
        })?;
        Ok(document.rosbag2_bagfile_information)
    }

    /// Writes the account into the bag's folder, under another name first, so that
    /// `metadata.yaml` is either absent or whole.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn write(&self, folder: &Path) -> Result<(), MetadataError> {
        let path = folder.join(FILE_NAME);
        let text = serde_yaml_ng::to_string(&Document {
            rosbag2_bagfile_information: self.clone(),
        })
        .map_err(|source| MetadataError::Format {
            path: path.clone(),
            source: source.into(),
        })?;
        write_text(&path, text).map_err(|source| MetadataError::Io { path, source })
    }
}
