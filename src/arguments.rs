//! Values on the command line: the parsers that several commands share.

use std::path::{Path, PathBuf};

use rustix::fs::{Access, access};

/// A parser of numbers in `[least, most]`.
pub fn within(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| match text.parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        _ => Err(format!("a number from {least} to {most} is expected")),
    }
}

/// A file that a command is to write. It is checked before the work is done: the folder exists and can be written,
/// and no file or folder of that name is there. A device such as `/dev/stdout` may be there.
///
/// # Errors
/// A sentence: what keeps the file from being written.
pub fn output_file(text: &str) -> Result<PathBuf, String> {
    let path = Path::new(text);
    if path.file_name().is_none() {
        return Err("the name of a file is expected".to_owned());
    }
    match path.metadata() {
        Ok(there) if there.is_dir() => return Err("it is a folder".to_owned()),
        Ok(there) if there.is_file() => {
            return Err("it exists already; name a new file".to_owned());
        }
        Ok(_) => return Ok(path.to_owned()),
        Err(_) => {}
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(format!("there is no folder '{}'", folder.display()));
    }
    access(folder, Access::WRITE_OK | Access::EXEC_OK)
        .map_err(|error| format!("the folder '{}': {error}", folder.display()))?;
    Ok(path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_is_refused_where_it_could_not_be_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name).display().to_string();
        std::fs::write(path("there.html"), "").expect("written");
        for (name, reason) in [
            (path("there.html"), "exists already"),
            (path("no/such/page.html"), "there is no folder"),
            (path("."), "it is a folder"),
            (path(".."), "the name of a file"),
        ] {
            let refusal = output_file(&name).expect_err(&name);
            assert!(refusal.contains(reason), "{name}: {refusal}");
        }
        for name in [
            path("new.html"),
            "/dev/null".to_owned(),
            "new.html".to_owned(),
        ] {
            assert_eq!(output_file(&name), Ok(PathBuf::from(&name)));
        }
    }
}
