//! Why a bag cannot be read.

use std::{
    io,
    path::{Path, PathBuf},
};

use crate::{defect::Defect, metadata::MetadataError};

/// The hint that converts a bag of another kind.
pub(crate) const CONVERTER: &str =
    "'rosbags-convert --src OLD --dst NEW --dst-storage mcap' (of PyPI's rosbags)";

/// Why a bag cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Nothing has that path.
    #[error(
        "{path}: no such file or folder; a bag is a folder, its metadata.yaml, or a .mcap or .db3 file"
    )]
    NotFound {
        /// The path asked for.
        path: PathBuf,
    },
    /// The file system refused.
    #[error("{path} cannot be read: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A file without a byte.
    #[error("{path} is empty; a .mcap or .db3 file is wanted")]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Something else than an MCAP file.
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
    /// A database that is no bag's, or is damaged.
    #[error("{path} cannot be read as a bag of rosbag2's sqlite3 storage: {reason}")]
    Database {
        /// The file.
        path: PathBuf,
        /// The reason that the database gives.
        reason: String,
    },
    /// A folder without `.mcap` and `.db3` files.
    #[error("{path} is no bag that can be read: it holds no .mcap or .db3 file{instead}")]
    NoMcap {
        /// The folder.
        path: PathBuf,
        /// Its contents and the remedy, if known.
        instead: String,
    },
    /// Files that are not the parts of one bag.
    #[error(
        "{path}: not one bag but several: {files}, whose {differ}; name one of them, or list them all, as experiments of their own"
    )]
    Several {
        /// The folder, or the first file.
        path: PathBuf,
        /// Their names.
        files: String,
        /// What tells them apart.
        differ: &'static str,
    },
    /// A storage other than MCAP.
    #[error(
        "{path} is a bag in rosbag2's '{storage}' storage; mcap and sqlite3 are read; {CONVERTER} makes one of it, as 'ros2 bag convert' does"
    )]
    Storage {
        /// The metadata.
        path: PathBuf,
        /// The storage it names.
        storage: String,
    },
    /// Files or messages compressed by rosbag2 rather than by MCAP, in a way that is not read.
    #[error(
        "{path} is a bag compressed by {mode} ({format}); read are MCAP's own chunk compression, messages and files packed with \
         zstd, and files that lie unpacked beside the packed ones"
    )]
    Compressed {
        /// The metadata.
        path: PathBuf,
        /// `file` or `message`.
        mode: String,
        /// The compressor.
        format: String,
    },
    /// `metadata.yaml` is not what it should be.
    #[error(transparent)]
    Metadata(#[from] MetadataError),
    /// A file that was closed, and damaged since.
    #[error("{path} is damaged at byte {offset}: {reason}; what comes before has been read")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where nothing more can be read.
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
