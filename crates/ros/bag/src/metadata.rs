//! `metadata.yaml`: rosbag2's description of a bag, written when the bag is closed.
//!
//! Fields and their order are those of rosbag2's `BagMetadata`, version 9 (Jazzy). Versions 1 to 8, which lack some fields or store the QoS as
//! text, can be read too. A bag without this file was not closed.

use std::{
    collections::BTreeMap,
    fs,
    io::{self, Read as _},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Deserializer, Serialize};

use planesman_text::{write_text, yaml};

use crate::OfferedQos;

/// Name of the file in the bag's folder.
pub const FILE_NAME: &str = "metadata.yaml";

/// Version written by this crate.
pub const VERSION: u32 = 9;

/// Largest file that is read, bytes: metadata of six thousand topics. Parsing YAML takes up to seventy times its size in memory.
const LONGEST: u64 = 4 << 20;

/// `starting_time` of a bag without messages, the same as in rosbag2.
pub(crate) const NEVER: i64 = i64::MAX;

/// Prefix of the keys for numbers of lost messages; the topic's name follows.
pub(crate) const DROPPED: &str = "dropped ";

/// Contents of `metadata.yaml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BagMetadata {
    /// Version of the format.
    pub version: u32,
    /// Storage plugin: `mcap`.
    pub storage_identifier: String,
    /// Time from the first to the last message.
    pub duration: Duration,
    /// Time of the first message.
    pub starting_time: StartingTime,
    /// Number of messages in all files.
    pub message_count: u64,
    /// All topics with their number of messages in all files.
    pub topics_with_message_count: Vec<TopicWithCount>,
    /// Compression of whole files or single messages; empty for uncompressed data. MCAP's own chunk compression is not recorded here.
    #[serde(default)]
    pub compression_format: String,
    /// `file`, `message`, or empty for uncompressed data.
    #[serde(default)]
    pub compression_mode: String,
    /// File names, in order.
    pub relative_file_paths: Vec<String>,
    /// Files with their times, in order.
    #[serde(default)]
    pub files: Vec<FileInformation>,
    /// Additional data of the recorder, as text.
    #[serde(default)]
    pub custom_data: Option<BTreeMap<String, String>>,
    /// ROS distribution whose conventions the bag follows.
    #[serde(default)]
    pub ros_distro: String,
}

/// A duration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Duration {
    /// Duration, ns.
    pub nanoseconds: i64,
}

/// A point in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct StartingTime {
    /// Time, ns since the epoch of the recording clock.
    pub nanoseconds_since_epoch: i64,
}

/// A topic with its number of messages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TopicWithCount {
    /// Description of the topic.
    pub topic_metadata: TopicMetadata,
    /// Number of messages in all files.
    pub message_count: u64,
}

/// A topic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TopicMetadata {
    /// Full name.
    pub name: String,
    /// ROS type.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Encoding of the payloads: `cdr`.
    #[serde(default)]
    pub serialization_format: String,
    /// QoS offered by the publishers; empty if the metadata has an older version with another format.
    #[serde(default, deserialize_with = "offers_or_none")]
    pub offered_qos_profiles: Vec<OfferedQos>,
    /// The type hash.
    #[serde(default)]
    pub type_description_hash: String,
}

/// One file of a bag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileInformation {
    /// File name in the bag's folder.
    pub path: String,
    /// Time of the first message.
    pub starting_time: StartingTime,
    /// Time from the first to the last message.
    pub duration: Duration,
    /// Number of messages.
    pub message_count: u64,
}

/// Top-level structure of the YAML file, with its only key.
#[derive(Serialize, Deserialize)]
struct Document {
    rosbag2_bagfile_information: BagMetadata,
}

fn offers_or_none<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<OfferedQos>, D::Error> {
    let value = serde_yaml_ng::Value::deserialize(deserializer)?;
    Ok(serde_yaml_ng::from_value(value).unwrap_or_default())
}

/// Errors of reading or writing `metadata.yaml`.
#[derive(Debug, thiserror::Error)]
pub enum MetadataError {
    /// An error of the file system.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file is too large.
    #[error("{path} has {length} bytes; the limit is {LONGEST}")]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Size of the file, bytes.
        length: u64,
    },
    /// The text is not rosbag2 metadata.
    #[error("{path} is not the metadata of a rosbag2 bag: {source}")]
    Format {
        /// The file.
        path: PathBuf,
        /// Error of the YAML parser, with its position.
        source: yaml::Error,
    },
}

impl BagMetadata {
    /// Metadata of a bag without files and messages.
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

    /// Total number of lost messages; this crate's writer stores them in [`custom_data`](Self::custom_data) under `dropped TOPIC`.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped_by_topic()
            .fold(0, |sum, (_, count)| sum.saturating_add(count))
    }

    /// Topics with lost messages, and their numbers.
    pub fn dropped_by_topic(&self) -> impl Iterator<Item = (&str, u64)> {
        self.custom_data
            .iter()
            .flatten()
            .filter_map(|(key, count)| Some((key.strip_prefix(DROPPED)?, count.parse().ok()?)))
    }

    /// Reads the metadata at `path`.
    ///
    /// # Errors
    /// The file cannot be read, is larger than 4 MiB, or is not rosbag2 metadata.
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

    /// Writes the metadata into the bag's folder, first under another name, so that `metadata.yaml` is either absent or complete.
    ///
    /// # Errors
    /// An error of the file system.
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
