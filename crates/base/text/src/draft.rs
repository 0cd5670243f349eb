//! Files that are written completely or not at all.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// A file being written next to its destination, under an unused random name (`O_EXCL`), so that no existing link is followed. Dropping it
/// removes the file.
#[derive(Debug)]
pub struct Draft {
    draft: NamedTempFile,
    place: PathBuf,
}

impl Draft {
    /// Starts a draft for the file `place`.
    ///
    /// # Errors
    /// `place` has no file name, or the draft cannot be created.
    pub fn of(place: &Path) -> io::Result<Self> {
        let name = place.file_name().ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidInput, "the path has no file name")
        })?;
        let mut begin = OsString::from(".");
        begin.push(name);
        begin.push(".");
        let draft = tempfile::Builder::new()
            .prefix(&begin)
            .suffix(".part")
            .make_in(folder_of(place), |path| File::create_new(path))?;
        let (file, path) = draft.into_parts();
        Ok(Self {
            draft: NamedTempFile::from_parts(file, path),
            place: place.to_owned(),
        })
    }

    /// The file, open for writing.
    pub fn file(&mut self) -> &mut File {
        self.draft.as_file_mut()
    }

    /// Moves the draft to its destination, replacing an existing file. Afterwards its content and its name survive a power cut.
    ///
    /// # Errors
    /// An error of the file system; an existing file stays unchanged.
    pub fn finish(self) -> io::Result<()> {
        self.draft.as_file().sync_all()?;
        self.draft.persist(&self.place).map_err(|it| it.error)?;
        // A folder that may not be read, and some file systems, cannot be synchronised.
        match File::open(folder_of(&self.place)).and_then(|folder| folder.sync_all()) {
            Err(error) if !is_unable(&error) => Err(error),
            _ => Ok(()),
        }
    }
}

fn is_unable(error: &io::Error) -> bool {
    use io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    [InvalidInput, PermissionDenied, Unsupported].contains(&error.kind())
}

fn folder_of(place: &Path) -> &Path {
    match place.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Writes a file completely or not at all, replacing an existing one. A pipe, a device or the target of a link is written in place instead.
///
/// # Errors
/// Errors of `write`, or of the file system.
pub fn write_whole<E: From<io::Error>>(
    place: &Path,
    write: impl FnOnce(&mut File) -> Result<(), E>,
) -> Result<(), E> {
    let is_special = |there: fs::Metadata| !there.is_file() && !there.is_dir();
    if place.symlink_metadata().is_ok_and(is_special) {
        return write(&mut File::create(place)?);
    }
    let mut draft = Draft::of(place)?;
    write(draft.file())?;
    Ok(draft.finish()?)
}

/// Writes a text file completely or not at all.
///
/// # Errors
/// An error of the file system.
pub fn write_text(place: &Path, text: impl AsRef<[u8]>) -> io::Result<()> {
    write_whole(place, |file| file.write_all(text.as_ref()))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _, symlink};

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        let name = |it: io::Result<fs::DirEntry>| it.expect("an entry").file_name();
        let names = entries.map(|it| name(it).to_string_lossy().into_owned());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_whole_or_as_it_was_and_no_draft_is_left() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = folder.path().join("page.html");
        write_text(&place, "first").expect("written");
        let broken_off: io::Result<()> = write_whole(&place, |file| {
            file.write_all(b"sec")?;
            assert_eq!(names(folder.path()).len(), 2);
            Err(io::Error::other("broken off"))
        });
        broken_off.expect_err("broken off");
        assert_eq!(fs::read(&place).expect("read"), b"first");
        write_text(&place, "second").expect("written");
        assert_eq!(fs::read(&place).expect("read"), b"second");
        assert_eq!(names(folder.path()), ["page.html"]);
        // As the umask has it, like any other file.
        let other = folder.path().join("other");
        fs::write(&other, "").expect("written");
        let mode = |path: &Path| fs::metadata(path).expect("there").permissions().mode();
        assert_eq!(mode(&place), mode(&other));
        write_text(Path::new("/"), "").expect_err("no file");
        write_text(folder.path(), "").expect_err("a folder");
    }

    #[test]
    fn the_name_of_a_draft_cannot_be_known_before() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = folder.path().join("page.html");
        let path = || Draft::of(&place).expect("a draft").draft.path().to_owned();
        let (one, other) = (path(), path());
        assert_ne!(one, other);
        let name = one
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        assert!(
            name.starts_with(".page.html.") && name.ends_with(".part"),
            "{name}"
        );
    }

    #[test]
    fn a_pipe_is_written_to_and_stays_a_pipe() {
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = folder.path().join("page.html");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.expect("mkfifo").success());
        let reads = pipe.clone();
        let reader = std::thread::spawn(move || fs::read(reads).expect("read"));
        write_text(&pipe, "page").expect("written");
        assert!(fs::metadata(&pipe).expect("there").file_type().is_fifo());
        assert_eq!(reader.join().expect("read"), b"page");
    }

    #[test]
    fn what_a_link_leads_to_is_written_and_the_link_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let [link, page] = ["link.html", "page.html"].map(|name| folder.path().join(name));
        symlink(&page, &link).expect("a link");
        write_text(&link, "page").expect("written");
        assert!(link.is_symlink());
        assert_eq!(fs::read(&page).expect("read"), b"page");
    }
}
