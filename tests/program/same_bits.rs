//! What the program computes is the same to the last bit on every machine (docs/loop.md): the hashes of `tests/machines/expected.txt`, made by the release
//! build, of this build too, of the C library without FMA and AVX2, and on one processor. `.ci/run` has the release build print all of them.

use std::fs;
use std::process::Command;

/// The C library's functions for processors with FMA and AVX2, left out.
const MASK: &str = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable";

/// The hashes of the flights, as a command prints them; taskset where it is named.
fn hashes(before: &[&str], tunables: &str) -> String {
    let mut words = before.to_vec();
    words.extend([
        "tests/machines/hashes.sh",
        "--flights",
        env!("CARGO_BIN_EXE_planesman"),
    ]);
    let run = Command::new(words[0])
        .args(&words[1..])
        .env("GLIBC_TUNABLES", tunables)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    String::from_utf8(run.stdout).unwrap()
}

#[test]
fn flights_and_a_sweep_have_the_hashes_of_every_other_machine() {
    let expected = fs::read_to_string("tests/machines/expected.txt").unwrap();
    let flights: Vec<&str> = expected.lines().take(10).collect();
    assert!(flights[9].ends_with("sweep dive"), "{flights:?}");
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let allowed = status
        .split("Cpus_allowed_list:")
        .nth(1)
        .unwrap()
        .trim_start();
    let first = allowed.split(|c: char| !c.is_ascii_digit()).next().unwrap();
    let alone = ["taskset", "--cpu-list", first];
    for (before, tunables) in [(&[][..], ""), (&[], MASK), (&alone, "")] {
        let found = hashes(before, tunables);
        assert_eq!(
            found.lines().collect::<Vec<_>>(),
            flights,
            "{before:?} {tunables}"
        );
    }
}
