//! File names of bags, and which files belong together.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{
    metadata,
    read_error::{CONVERTER, ReadError},
    recording::Recording,
};

/// Whether the name is that of a bag file, possibly one of several: `.mcap` or `.db3`, compressed as a whole or not.
#[must_use]
pub fn is_bag_file(file: &Path) -> bool {
    is_plain(file) || is_packed(file)
}

/// Whether the name is that of an uncompressed bag file.
pub(crate) fn is_plain(file: &Path) -> bool {
    file.extension()
        .is_some_and(|extension| extension == "mcap" || extension == "db3")
}

/// Whether the name is that of a file compressed as a whole by rosbag2: `NAME.mcap.zstd`.
pub(crate) fn is_packed(file: &Path) -> bool {
    let ending = file.extension().unwrap_or_default();
    (ending == "zstd" || ending == "zst") && is_plain(&file.with_extension(""))
}

/// The files listed in the metadata; if none of them exists, for example after renaming, the bag files that do exist, with a note.
pub(crate) fn present(
    mut listed: Vec<PathBuf>,
    folder: &Path,
) -> Result<(Vec<PathBuf>, Option<String>), ReadError> {
    let missing: Vec<PathBuf> = listed.iter().filter(|it| !it.exists()).cloned().collect();
    if missing.is_empty() && !listed.is_empty() {
        return Ok((listed, None));
    }
    let others = match missing.len() == listed.len() {
        true => bag_files(folder)?,
        false => Vec::new(),
    };
    let said = format!(
        "the bag's metadata.yaml lists {}, which does not exist",
        self::listed(&missing)
    );
    if !others.is_empty() {
        let said = format!("{said}; reading {} instead", self::listed(&others));
        return Ok((others, Some(said)));
    }
    // If no name exists, the first one is opened, so that the error names it.
    if missing.len() < listed.len() {
        listed.retain(|it| it.exists());
    }
    Ok((listed, Some(said)))
}

/// The uncompressed file next to a compressed one, if it exists.
pub(crate) fn unpacked(file: PathBuf) -> PathBuf {
    let beside = file.with_extension("");
    if !is_plain(&file) && beside.is_file() {
        beside
    } else {
        file
    }
}

/// The other contents of a folder without `.mcap` files, with the next command.
pub(crate) fn instead(folder: &Path) -> String {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    let mut bags: Vec<PathBuf> = paths
        .filter(|path| path.join(metadata::FILE_NAME).is_file())
        .collect();
    if !bags.is_empty() {
        bags.sort();
        return format!(
            ", but it contains folders with bags ({}): name one of them, or name all of them as separate experiments",
            listed(&bags)
        );
    }
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut endings = entries.filter_map(|entry| entry.path().extension().map(ToOwned::to_owned));
    endings
        .find_map(|ending| match ending.to_str()? {
            "bag" => Some(format!(
                ", but it contains .bag files of ROS 1; convert them with {CONVERTER}"
            )),
            _ => None,
        })
        .unwrap_or_default()
}

/// The `.mcap` and `.db3` files in `folder` in the order they were written (`NAME_2` before `NAME_10`); compressed files only if there is no
/// uncompressed copy.
pub(crate) fn bag_files(folder: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let unreadable = |source| ReadError::open(folder, source);
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let is_alone = || !path.with_extension("").is_file();
        if is_plain(&path) || (is_packed(&path) && is_alone()) {
            files.push(path);
        }
    }
    files.sort_by_cached_key(|path| part_of(path));
    Ok(files)
}

/// Name of the bag that a file belongs to, and the file's number: `NAME_2.mcap`.
pub(crate) fn part_of(file: &Path) -> (String, u64) {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.split_once('.').map_or(&*name, |(stem, _)| stem);
    let (name, number) = stem.rsplit_once('_').unwrap_or((stem, ""));
    match number.parse::<u64>() {
        Ok(number) => (name.to_owned(), number),
        Err(_) => (stem.to_owned(), 0),
    }
}

/// Largest overlap in time, ns, of two parts of one bag; a recorder with several threads may cause it.
const OVERLAP: i64 = 1_000_000_000;

/// The reason why files cannot be parts of one bag; `None` if they can.
pub(crate) fn apart(recordings: &[Recording]) -> Option<&'static str> {
    let mut spans: Vec<(i64, i64)> = recordings.iter().filter_map(|it| it.span).collect();
    spans.sort_unstable();
    if spans
        .windows(2)
        .any(|it| it[1].0 < it[0].1.saturating_sub(OVERLAP))
    {
        return Some("times overlap");
    }
    let mut names = recordings.iter().map(|it| part_of(&it.path).0);
    let first = names.next();
    names
        .any(|name| Some(name) != first)
        .then_some("names differ")
}

/// Names of files; only the first few if there are many.
pub(crate) fn listed(files: &[PathBuf]) -> String {
    const LISTED: usize = 4;
    let name = |file: &PathBuf| {
        let name = file.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    };
    let mut names: Vec<String> = files.iter().take(LISTED).map(name).collect();
    if files.len() > LISTED {
        names.push(format!("and {} more", files.len() - LISTED));
    }
    names.join(", ")
}
