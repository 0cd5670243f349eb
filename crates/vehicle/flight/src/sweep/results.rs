//! The results' file: one row per case in the order of the cases, independent of the number of cores and of interruptions.
//!
//! Workers take cases in order. A row that is ready early waits in memory for the rows before it. No worker is more than 1024 cases ahead, so memory
//! does not grow with the number of cases. The file therefore always has complete rows from the first case on, except for a partial last row after a
//! power failure. To continue, only the number of its complete rows is needed.

use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io::{BufRead as _, BufReader, Seek as _, SeekFrom, Write as _};
use std::num::NonZero;
use std::path::Path;
use std::sync::{Condvar, Mutex, PoisonError};

use crate::error::{During, Error, Result, refuse, refused};

/// Largest number of cases begun beyond the first unwritten one.
const AHEAD: u64 = 1024;

/// Name of a part's file.
pub fn file_of(part: u64, parts: u64) -> String {
    format!("cases-{part}-of-{parts}.csv")
}

/// The file, open for the missing rows.
pub struct Results {
    file: File,
    /// Number of rows that the file already had.
    pub there: u64,
}

impl Results {
    /// Opens the file for more rows, or creates it with its header row.
    ///
    /// # Errors
    /// If it cannot be written, another process is writing it, or it has another header.
    pub fn open(path: &Path, header: &str) -> Result<Self> {
        let named = || format!("'{}'", path.display());
        let mut options = File::options();
        let mut file = options
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .during(named)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                refuse!("{}: another sweep is writing this file", named())
            }
            Err(TryLockError::Error(error)) => return Err(error).during(named),
        }
        let mut whole = 0;
        let mut rows = 0_u64;
        let mut line = Vec::new();
        let mut lines = BufReader::new(&file);
        while lines.read_until(b'\n', &mut line)? > 0 && line.ends_with(b"\n") {
            if rows == 0 && line != header.as_bytes() {
                refuse!(
                    "{}: the existing file has other columns. Name a new folder",
                    named()
                );
            }
            whole += line.len() as u64;
            rows += 1;
            line.clear();
        }
        file.set_len(whole).during(named)?;
        file.seek(SeekFrom::End(0))?;
        if rows == 0 {
            file.write_all(header.as_bytes()).during(named)?;
        }
        Ok(Self {
            file,
            there: rows.saturating_sub(1),
        })
    }

    /// Appends the rows up to `all`; `row` computes a row by its number on `threads` threads, and `written` is called for each.
    ///
    /// # Errors
    /// If a row cannot be computed or written. The file then ends with the row before it.
    pub fn fill(
        self,
        all: u64,
        jobs: NonZero<usize>,
        row: impl Fn(u64) -> Result<Vec<u8>> + Sync,
        written: impl Fn() + Sync,
    ) -> Result<()> {
        let shared = Mutex::new(Shared {
            file: self.file,
            next: self.there,
            written: self.there,
            ready: BTreeMap::new(),
            failure: None,
        });
        let moved_on = Condvar::new();
        let locked = || shared.lock().unwrap_or_else(PoisonError::into_inner);
        let work = || {
            loop {
                let too_far = |it: &mut Shared| {
                    it.failure.is_none() && it.next < all && it.next - it.written >= AHEAD
                };
                let mut state = moved_on
                    .wait_while(locked(), too_far)
                    .unwrap_or_else(PoisonError::into_inner);
                if state.failure.is_some() || state.next >= all {
                    return;
                }
                let number = state.next;
                state.next += 1;
                drop(state);
                // A panic of a row is a failure of the sweep, not a wait without end.
                let outcome =
                    std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| row(number)))
                        .unwrap_or_else(|_| Err(refused!("case {number} failed")));
                let mut state = locked();
                let outcome = outcome.and_then(|row| state.put(number, row));
                match outcome {
                    Ok(rows) => (0..rows).for_each(|_| written()),
                    Err(error) => {
                        state.failure.get_or_insert(error);
                    }
                }
                drop(state);
                moved_on.notify_all();
            }
        };
        std::thread::scope(|scope| {
            // This thread works too, and alone where the system gives no other.
            for _ in 1..jobs.get() {
                if std::thread::Builder::new()
                    .spawn_scoped(scope, work)
                    .is_err()
                {
                    break;
                }
            }
            work();
        });
        let shared = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
        shared.failure.map_or(Ok(()), Err)
    }
}

/// State shared by the workers.
struct Shared {
    file: File,
    /// Next row to compute.
    next: u64,
    /// Next row to write.
    written: u64,
    /// Rows that wait for an earlier one.
    ready: BTreeMap<u64, Vec<u8>>,
    failure: Option<Error>,
}

impl Shared {
    /// Adds a row, and writes all rows that are next in order; returns their number.
    fn put(&mut self, number: u64, row: Vec<u8>) -> Result<u64> {
        self.ready.insert(number, row);
        let before = self.written;
        while let Some(row) = self.ready.remove(&self.written) {
            self.file
                .write_all(&row)
                .during(|| "cannot write the results")?;
            self.written += 1;
        }
        Ok(self.written - before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    const HEADER: &str = "case\n";

    fn fill(path: &Path, all: u64, jobs: usize, fails_at: Option<u64>) -> Result<u64> {
        let computed = AtomicU64::new(0);
        let row = |number: u64| {
            computed.fetch_add(1, Ordering::Relaxed);
            std::thread::sleep(std::time::Duration::from_micros(number * 7919 % 200));
            match fails_at == Some(number) {
                true => refuse!("a fault"),
                false => Ok(format!("{number}\n").into_bytes()),
            }
        };
        let jobs = NonZero::new(jobs).expect("some");
        Results::open(path, HEADER)?.fill(all, jobs, row, || {})?;
        Ok(computed.into_inner())
    }

    #[test]
    fn rows_stand_in_order_whoever_computed_them_and_none_is_computed_twice_after_an_interruption()
    {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("cases.csv");
        let whole: String =
            HEADER.to_owned() + &(0..300).map(|i| format!("{i}\n")).collect::<String>();
        fill(&path, 300, 4, Some(120)).expect_err("broken off");
        let part = std::fs::read_to_string(&path).expect("read");
        assert!(whole.starts_with(&part) && part.len() < whole.len());
        // As when the machine is lost while a row is written.
        let torn = part.clone() + "1";
        std::fs::write(&path, torn).expect("written");
        let there = part.lines().count() as u64 - 1;
        assert_eq!(fill(&path, 300, 3, None).expect("filled"), 300 - there);
        assert_eq!(std::fs::read_to_string(&path).expect("read"), whole);
        assert_eq!(fill(&path, 300, 3, None).expect("nothing to do"), 0);
        assert!(Results::open(&path, "other\n").is_err());
    }

    #[test]
    fn a_file_has_one_writer() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("cases.csv");
        let first = Results::open(&path, HEADER).expect("opened");
        let refusal = Results::open(&path, HEADER).err().expect("refused");
        assert!(refusal.to_string().contains("another sweep"), "{refusal}");
        drop(first);
        Results::open(&path, HEADER).expect("opened");
    }
}
