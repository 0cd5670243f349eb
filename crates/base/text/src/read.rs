//! Reads text files of limited size.

use std::io::Read as _;
use std::path::Path;
use std::{fs, io};

/// Largest file that [`read`] accepts, bytes: hundreds of times the size of handwritten files.
pub const LARGEST: u64 = 1 << 20;

/// Reads a handwritten text file: a parameter file, a scenario, an actuator. A byte-order mark is removed.
///
/// # Errors
/// The file cannot be read, is not a regular file (a pipe may block, a device may be endless), is larger than [`LARGEST`], or is not UTF-8.
pub fn read(path: &Path) -> io::Result<String> {
    let refuse = |reason: String| io::Error::new(io::ErrorKind::InvalidData, reason);
    if !fs::metadata(path)?.is_file() {
        return Err(refuse("it is not a regular file".to_owned()));
    }
    let mut bytes = Vec::new();
    fs::File::open(path)?
        .take(LARGEST + 1)
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LARGEST {
        return Err(refuse(format!("it is larger than {LARGEST} bytes")));
    }
    decoded(&bytes)
        .map(str::to_owned)
        .map_err(|it| refuse(it.to_owned()))
}

/// Decodes UTF-8 bytes, without the byte-order mark that some editors write.
///
/// # Errors
/// A sentence that says what the bytes are instead.
pub fn decoded(bytes: &[u8]) -> Result<&str, &'static str> {
    std::str::from_utf8(unmarked(bytes)?).map_err(|_| "it is not UTF-8 text")
}

/// The bytes after a UTF-8 byte-order mark, if there is one.
///
/// # Errors
/// A sentence, if they begin with a UTF-16 byte-order mark.
pub fn unmarked(bytes: &[u8]) -> Result<&[u8], &'static str> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err("it is UTF-16 text; save it as UTF-8");
    }
    Ok(bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_regular_file_of_text_and_reasonable_size_is_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("file.yaml");
        for (content, refusal) in [
            (vec![b'#'; LARGEST as usize], None),
            (vec![b'#'; LARGEST as usize + 1], Some("larger")),
            (vec![0xff, 0xd8], Some("UTF-8")),
        ] {
            fs::write(&path, &content).expect("written");
            let read = read(&path).map_err(|error| error.to_string());
            match refusal {
                None => assert_eq!(read.expect("text").into_bytes(), content),
                Some(part) => assert!(read.expect_err(part).contains(part)),
            }
        }
        for path in [folder.path(), Path::new("/dev/zero")] {
            let refusal = read(path).expect_err("no file").to_string();
            assert!(refusal.contains("regular file"), "{refusal}");
        }
    }

    #[test]
    fn a_byte_order_mark_is_passed_over_and_utf_16_is_refused_by_name() {
        assert_eq!(decoded(b"\xef\xbb\xbfa: 1\n"), Ok("a: 1\n"));
        assert_eq!(decoded("a: ü\n".as_bytes()), Ok("a: ü\n"));
        for bytes in [&b"\xff\xfea\0"[..], b"\xfe\xff\0a"] {
            assert!(decoded(bytes).is_err_and(|reason| reason.contains("UTF-16")));
        }
    }
}
