//! What a client does to the server of `planesman watch` over raw sockets: it goes on answering the page, in the memory it has.

use std::collections::VecDeque;
use std::fs;
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::process::Command;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use libtest_mimic::Trial;
use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus, KeyValue};
use planesman_msgs::planesman_msgs::msg::VehicleState;
use planesman_node::Qos;
use rustix::process::{Resource, getrlimit, setrlimit};

use super::page::{Page, watch};
use super::stage::{Process, Stage, eventually};
use super::trial;

/// By how much the process may grow, MiB, whatever clients do.
const GROWTH: u64 = 48;
/// Connections of one address, and its streams (`crates/show/watch/src/visitors.rs`).
const CONNECTIONS: usize = 64;
const STREAMS: usize = 16;

pub(crate) fn trials() -> Vec<Trial> {
    let rows: [(&str, fn()); 7] = [
        ("half_sent_requests", half_sent_requests),
        ("strangers_without_end", strangers_without_end),
        ("streams", streams),
        ("readers_that_never_read", readers_that_never_read),
        ("refused_names", refused_names),
        ("bag_links", bag_links),
        ("two_servers_of_an_address", two_servers_of_an_address),
    ];
    let named = rows.into_iter();
    named
        .map(|(name, run)| trial(format!("page/{name}"), true, run))
        .collect()
}

/// A number of the process, as `VmRSS` (memory now) or `VmHWM` (the most), MiB.
fn memory(program: &Process, name: &str) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", program.id())).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix(name));
    let kib = line.unwrap().trim_start_matches(':').trim_end_matches("kB");
    kib.trim().parse::<u64>().unwrap() / 1024
}

fn descriptors(program: &Process) -> usize {
    let folder = format!("/proc/{}/fd", program.id());
    fs::read_dir(folder).unwrap().count()
}

fn assert_answers(page: &Page) {
    let answer = page.get("/charts");
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
}

/// Whether the server has closed the connection; waits for that.
fn ends(stream: &mut TcpStream) -> bool {
    match stream.read_to_end(&mut Vec::new()) {
        Ok(_) => true,
        Err(error) => error.kind() == std::io::ErrorKind::ConnectionReset,
    }
}

/// As many as fill a process' descriptors: they give way to the page, and end by themselves.
fn half_sent_requests() {
    let stage = Stage::new();
    let (program, page) = watch(&stage);
    assert_answers(&page);
    let before = descriptors(&program);
    let mut limit = getrlimit(Resource::Nofile);
    limit.current = limit.maximum;
    setrlimit(Resource::Nofile, limit).unwrap();
    let head = format!("GET / HTTP/1.1\r\nHost: {}", page.host);
    let half = (0..990).map(|_| page.send(&head));
    let mut half: Vec<TcpStream> = half.collect();
    // A stranger who says nothing, and the page's own request that does not come to its end.
    half.push(page.send(""));
    let body = "Content-Type: application/json\r\nContent-Length: 99\r\n\r\n{\"do\"";
    let own = page.own().join("\r\n");
    let mut late = page.send(&format!("POST /do HTTP/1.1\r\n{own}\r\n{body}"));
    assert_answers(&page);
    let open = descriptors(&program);
    println!("{before} descriptors, then {open}");
    assert!(open <= before + CONNECTIONS, "{open} descriptors are open");
    assert!(half.iter_mut().all(ends));
    let mut answer = String::new();
    late.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 408"), "{answer}");
    assert_answers(&page);
}

/// Others of this machine connect as often as they can: the page's stream goes on, and so do its requests, which a browser repeats.
fn strangers_without_end() {
    let stage = Stage::new();
    let (program, page) = watch(&stage);
    let mut stream = page.stream(&[]);
    let mut part = vec![0; 1 << 16];
    assert!(stream.read(&mut part).unwrap() > 0);
    let before = memory(&program, "VmRSS");
    let (came, is_over) = (AtomicUsize::new(0), AtomicBool::new(false));
    let head = format!("GET / HTTP/1.1\r\nHost: {}", page.host);
    let connect = |rest: &str| {
        let (mut open, text) = (VecDeque::new(), format!("{head}{rest}"));
        while !is_over.load(Ordering::Relaxed) {
            // One may be closed before it has spoken.
            if let Ok(mut one) = TcpStream::connect(&page.host) {
                let _ = one.write_all(text.as_bytes());
                open.push_back(one);
                came.fetch_add(1, Ordering::Relaxed);
            }
            if open.len() > 200 {
                open.pop_front();
            }
        }
    };
    std::thread::scope(|scope| {
        for rest in ["", "\r\n\r\n"] {
            scope.spawn(move || connect(rest));
        }
        let (mut answered, mut lost) = (0, 0);
        eventually("answers among a thousand strangers", || {
            let own = page.own();
            let answer = page.try_answer("GET /charts", &own.each_ref().map(String::as_str), "");
            match answer.is_ok_and(|it| it.starts_with("HTTP/1.1 200")) {
                true => answered += 1,
                false => lost += 1,
            }
            (answered >= 50 && came.load(Ordering::Relaxed) >= 1000).then_some(())
        });
        is_over.store(true, Ordering::Relaxed);
        println!("{came:?} strangers, {answered} requests answered, {lost} lost");
        assert!(answered > 10 * lost, "{answered} answered, {lost} lost");
    });
    for _ in 0..3 {
        assert!(stream.read(&mut part).unwrap() > 0, "the stream has ended");
    }
    let most = memory(&program, "VmHWM");
    println!("{before} MiB, then at most {most} MiB");
    assert!(most < before + 16, "{before} MiB, then {most} MiB");
}

/// The oldest of one address end for those that come after them.
fn streams() {
    let stage = Stage::new();
    let (_program, page) = watch(&stage);
    let mut all: Vec<TcpStream> = (0..40)
        .map(|_| {
            let mut stream = page.stream(&["/auv/state:depth"]);
            let mut status = [0; 12];
            stream.read_exact(&mut status).unwrap();
            assert_eq!(&status, b"HTTP/1.1 200");
            stream
        })
        .collect();
    let (old, new) = all.split_at_mut(40 - STREAMS);
    assert!(old.iter_mut().all(ends));
    for stream in new {
        stream
            .set_read_timeout(Some(Duration::from_millis(1)))
            .unwrap();
        let outcome = stream.read_to_end(&mut Vec::new());
        assert!(outcome.is_err(), "one of the newest has ended");
    }
    assert_answers(&page);
}

/// Pages with all the history of one channel, named as often as an address holds, who do not read what they are sent.
fn readers_that_never_read() {
    const HISTORY: usize = 20_000;
    let stage = Stage::new();
    let operator = stage.operator();
    let (program, page) = watch(&stage);
    let qos = Qos::reliable(1000);
    let publisher = operator.rt.publisher::<VehicleState>("state", qos).unwrap();
    eventually("watch reads the states", || {
        operator.rt.next(Duration::from_millis(10));
        (publisher.readers() > 0).then_some(())
    });
    let mut state = VehicleState::default();
    for k in 0..HISTORY {
        state.header.stamp.sec = i32::try_from(1 + k / 1000).unwrap();
        state.header.stamp.nanosec = u32::try_from(k % 1000).unwrap() * 1_000_000;
        state.depth = 1.0 / (k as f64 + 3.0);
        publisher.publish(&state);
        if k % 100 == 0 {
            operator.rt.next(Duration::from_millis(10));
        }
    }
    // One that reads gets them, each once though it names the channel twice.
    let channel = "/auv/state:depth";
    let mut reading = page.stream(&[channel, channel]);
    let (mut text, mut part) = (String::new(), vec![0; 1 << 16]);
    eventually("the history", || {
        let count = reading.read(&mut part).unwrap();
        text += &String::from_utf8_lossy(&part[..count]);
        text.contains("20.9").then_some(())
    });
    assert!(text.contains("\"series\":[[0,"), "{}", &text[..500]);
    assert!(!text.contains("[1,false,") && !text.contains("],[1,"));

    let before = memory(&program, "VmRSS");
    let many = vec![channel; 256];
    let _deaf: Vec<TcpStream> = (0..31).map(|_| page.stream(&many)).collect();
    let fields = ["pitch", "surge", "distance", "dive_planes"].map(|it| format!("/auv/state:{it}"));
    let fields: Vec<&str> = fields
        .iter()
        .map(String::as_str)
        .cycle()
        .take(256)
        .collect();
    let _deaf_too: Vec<TcpStream> = (0..31).map(|_| page.stream(&fields)).collect();
    for _ in 0..20 {
        assert_answers(&page);
        std::thread::sleep(Duration::from_millis(100));
    }
    let most = memory(&program, "VmHWM");
    println!("{before} MiB, then at most {most} MiB");
    assert!(most < before + GROWTH, "{before} MiB, then {most} MiB");
}

/// Names of channels that nobody publishes are not kept for ever, and leave room for one that somebody does.
fn refused_names() {
    let stage = Stage::new();
    let (program, page) = watch(&stage);
    assert_answers(&page);
    let before = memory(&program, "VmRSS");
    let long = "x".repeat(430);
    for k in 0..271 {
        let names: Vec<String> = (0..120).map(|j| format!("/n{k}_{j}_{long}:f")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut stream = page.stream(&names);
        let mut status = [0; 12];
        stream.read_exact(&mut status).unwrap();
        assert_eq!(&status, b"HTTP/1.1 200");
        let kept = serde_json::json!({"do": "keep", "channels": names});
        let answer = page.post(&kept.to_string());
        assert!(answer.contains("\"ok\":true"), "{answer}");
    }
    let most = memory(&program, "VmHWM");
    println!("{before} MiB, then at most {most} MiB");
    assert!(most < before + 16, "{before} MiB, then {most} MiB");
    let answer = page.post(r#"{"do":"keep","channels":["/auv/state:depth"]}"#);
    assert!(answer.contains("\"refused\":[null]"), "{answer}");
    let endless = format!(r#"{{"do":"keep","channels":["/{}:f"]}}"#, "x".repeat(600));
    let answer = page.post(&endless);
    assert!(answer.contains("at most 512 bytes"), "{answer}");
}

/// A diagnostic names what is no bag: nothing of it is opened, and the page goes on.
fn bag_links() {
    let stage = Stage::new();
    let operator = stage.operator();
    let (_program, page) = watch(&stage);
    let qos = Qos::reliable(10);
    let diagnostics = operator.rt.publisher("/diagnostics", qos).unwrap();
    let pipe = stage.path("pipe");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let link = stage.path("link");
    std::os::unix::fs::symlink(&pipe, &link).unwrap();
    let folder = stage.path("folder");
    fs::create_dir(&folder).unwrap();
    let text = stage.file("text.mcap", "no MCAP at all");
    let content = [&b"\x89MCAP0\r\n"[..], &[b'.'; 200_000]].concat();
    let bag = stage.file("bag.mcap", &content);
    for (path, status, part) in [
        (pipe.as_str(), 404, "it is not a regular file"),
        (&link, 404, "it is not a regular file"),
        (&folder, 404, "it is not a regular file"),
        ("/dev/zero", 404, "it is not a regular file"),
        ("/dev/tty", 404, "it is not a regular file"),
        (&text, 404, "the file is not a bag"),
        ("/no/such/bag.mcap", 404, "No such file"),
        (&bag, 200, "filename=\"bag.mcap\""),
    ] {
        let array = DiagnosticArray {
            status: vec![DiagnosticStatus {
                name: "/auv/recorder: bag".to_owned(),
                values: vec![KeyValue {
                    key: "file".to_owned(),
                    value: path.to_owned(),
                }],
                ..DiagnosticStatus::default()
            }],
            ..DiagnosticArray::default()
        };
        let answer = eventually(path, || {
            diagnostics.publish(&array);
            operator.rt.next(Duration::from_millis(10));
            let answer = page.get("/bag?node=/auv/recorder");
            (answer.contains(part) && (status == 200 || answer.contains(path))).then_some(answer)
        });
        assert!(
            answer.starts_with(&format!("HTTP/1.1 {status}")),
            "{answer}"
        );
        // More at once than there are threads for files.
        let own = page.own().join("\r\n");
        let request = format!("GET /bag?node=/auv/recorder HTTP/1.1\r\n{own}\r\n\r\n");
        let _asked: Vec<TcpStream> = (0..20).map(|_| page.send(&request)).collect();
        assert_answers(&page);
    }
    let answer = page.get("/bag?node=/auv/recorder");
    let (_, body) = answer.split_once("\r\n\r\n").unwrap();
    let dots = body.bytes().filter(|it| *it == b'.').count();
    assert_eq!(dots, 200_000);
}

/// A browser has one jar of cookies for all ports of an address: each server knows its own, and another's is no good.
fn two_servers_of_an_address() {
    let stages = [Stage::new(), Stage::new()];
    let [(_first, one), (_second, other)] = stages.each_ref().map(watch);
    assert_ne!(one.token, other.token);
    let value = |page: &Page| page.cookie()["Cookie: ".len()..].to_owned();
    let jar = format!("Cookie: {}; {}", value(&one), value(&other));
    for page in [&one, &other] {
        let host = format!("Host: {}", page.host);
        let answer = page.answer("GET /charts", &[&host, &jar], "");
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    }
    for (page, wrong) in [(&one, &other), (&other, &one)] {
        let host = format!("Host: {}", page.host);
        let forged = page.cookie().replace(&page.token, &wrong.token);
        for cookie in [wrong.cookie(), forged] {
            let answer = page.answer("GET /charts", &[&host, &cookie], "");
            assert!(answer.starts_with("HTTP/1.1 401"), "{answer}");
        }
    }
}
