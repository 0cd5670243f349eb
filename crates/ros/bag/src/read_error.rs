//! Errors of reading a bag.

use std::{
    io,
    path::{Path, PathBuf},
};

use crate::{defect::Defect, metadata::MetadataError};

/// Command that converts a bag of another format.
pub(crate) const CONVERTER: &str =
    "'rosbags-convert --src OLD --dst NEW --dst-storage mcap' (of PyPI's rosbags)";

/// The reason why a bag cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The path does not exist.
    #[error(
        "{path}: no such file or folder; a bag is a folder, its metadata.yaml, or a .mcap or .db3 file"
    )]
    NotFound {
        /// Requested path.
        path: PathBuf,
    },
    /// An error of the file system.
    #[error("{path} cannot be read: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// An empty file.
    #[error("{path} is empty; a .mcap or .db3 file is expected")]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The file is not an MCAP file.
    #[error(
        "{path} is not an MCAP file but {found}; a bag is a folder, its metadata.yaml, or a .mcap file"
    )]
    NotABag {
        /// The file.
        path: PathBuf,
        /// Its probable format.
        found: &'static str,
    },
    /// The file is cut off before its first record.
    #[error("{path} is cut off or damaged in its header: no message can be read")]
    NoHeader {
        /// The file.
        path: PathBuf,
    },
    /// A damaged database, or one that is not a bag.
    #[error("{path} cannot be read as a bag of rosbag2's sqlite3 storage: {reason}")]
    Database {
        /// The file.
        path: PathBuf,
        /// Error text of the database.
        reason: String,
    },
    /// A folder without `.mcap` and `.db3` files.
    #[error("{path} is not a bag: it contains no .mcap or .db3 file{instead}")]
    NoMcap {
        /// The folder.
        path: PathBuf,
        /// The actual content of the file, with the next command if one is known.
        instead: String,
    },
    /// Files that are not the parts of one bag.
    #[error(
        "{path}: these files are several bags ({differ}): {files}; name one of them, or name all of them as separate experiments"
    )]
    Several {
        /// The folder, or the first file.
        path: PathBuf,
        /// Names of the files.
        files: String,
        /// The reason why the files cannot be one bag.
        differ: &'static str,
    },
    /// An unsupported storage plugin.
    #[error(
        "{path} is a bag with the storage '{storage}', but only mcap and sqlite3 are supported. Convert it with {CONVERTER} or 'ros2 bag convert'"
    )]
    Storage {
        /// Path of the metadata.
        path: PathBuf,
        /// Storage named there.
        storage: String,
    },
    /// Files or messages compressed by rosbag2 in an unsupported way.
    #[error(
        "{path} is a bag with unsupported compression by {mode} ({format}). Supported are MCAP's chunk compression, and messages and files compressed with zstd. Uncompressed copies next to the compressed files are read too"
    )]
    Compressed {
        /// Path of the metadata.
        path: PathBuf,
        /// `file` or `message`.
        mode: String,
        /// The compressor.
        format: String,
    },
    /// Unreadable or invalid `metadata.yaml`.
    #[error(transparent)]
    Metadata(#[from] MetadataError),
    /// The file was damaged after it was closed.
    #[error(
        "{path} is damaged at byte {offset}: {reason}; everything before this byte has been read"
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Position from which the file is unreadable, bytes.
        offset: u64,
        /// The reason.
        reason: Defect,
    },
}

impl ReadError {
    pub(crate) fn database(path: &Path, error: &rusqlite::Error) -> Self {
        Self::Database {
            path: path.to_owned(),
            reason: error.to_string(),
        }
    }

    pub(crate) fn open(path: &Path, source: io::Error) -> Self {
        let path = path.to_owned();
        if source.kind() == io::ErrorKind::NotFound {
            Self::NotFound { path }
        } else {
            Self::Io { path, source }
        }
    }
}
