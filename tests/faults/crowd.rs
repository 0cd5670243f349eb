//! Many vehicles started at once, all in one domain: each finds its own and flies.

use std::path::Path;
use std::process::{Child, Command, Stdio};

use libtest_mimic::Trial;

use super::evidence;
use super::foreign::root;
use super::stage::{LONG_WORK, Process, Stage, eventually, scenario};
use super::trial;

pub(crate) fn trials() -> Vec<Trial> {
    let names = [("crowd/six_vehicles", 6), ("crowd/ten_vehicles", 10)];
    let crowd =
        |(name, vehicles): (&str, u32)| trial(name.to_owned(), false, move || all_fly(vehicles));
    names.into_iter().map(crowd).collect()
}

fn all_fly(vehicles: u32) {
    let stage = Stage::new();
    let place = Place::new();
    let file = stage.file("short.yaml", scenario(10.0, "  sysid: {start: 2.0}\n"));
    let dives: Vec<(Process, String)> = (0..vehicles)
        .map(|vehicle| {
            let (name, out) = (
                format!("/auv{vehicle}"),
                stage.path(&format!("out-{vehicle}")),
            );
            let arguments = [
                "dive",
                &file,
                "--lockstep",
                "--namespace",
                &name,
                "--out",
                &out,
            ];
            (stage.start_at(&place.command(), &arguments, &[]), out)
        })
        .collect();
    let mut fates = Vec::new();
    for (launcher, out) in dives {
        let outcome = launcher.finish_within(LONG_WORK);
        let fate = match outcome.status.code() {
            Some(0) => {
                let flight = evidence::whole_flight(&Path::new(&out).join("bag"));
                Ok(evidence::each_tick_is_there(&flight))
            }
            _ => Err(outcome.complaints().join(" ")),
        };
        fates.push(fate);
    }
    assert!(fates.iter().all(|fate| *fate == Ok(200)), "{fates:#?}");
}

/// A network namespace whose loopback has multicast, gone when dropped.
struct Place {
    holder: Child,
}

impl Place {
    fn new() -> Self {
        let script = root().join("tests/netns.sh");
        let mut command = Command::new(script);
        let holder = command
            .arg("cat")
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let place = Self { holder };
        // Until then the process is still where we are.
        let own = std::fs::read_link("/proc/self/ns/net").unwrap();
        eventually("a network namespace", || {
            let command =
                std::fs::read_to_string(format!("/proc/{}/comm", place.holder.id())).ok()?;
            let there = std::fs::read_link(format!("/proc/{}/ns/net", place.holder.id())).ok()?;
            (command.trim() == "cat" && there != own).then_some(())
        });
        place
    }

    fn command(&self) -> Vec<String> {
        super::network::inside(self.holder.id())
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = self.holder.kill();
        let _ = self.holder.wait();
    }
}
