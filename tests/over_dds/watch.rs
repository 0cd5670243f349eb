//! `planesman watch`: the page in a browser without a screen, and who is answered.
//!
//! Where Chromium or what drives it is absent, the tests of the page pass, saying what they skipped (tests/README.md).

use crate::browser;
use crate::page;
use crate::stage;
use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use crate::foreign::peers::{root, skip};
use page::{Page, watch};
use planesman_msgs::Message as _;
use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use planesman_msgs::rcl_interfaces::msg::Log;
use planesman_msgs::rcl_interfaces::srv::{GetParameters, GetParametersRequest};
use planesman_msgs::std_msgs::msg::Float64;
use planesman_node::Qos;
use rustdds::{DomainParticipantBuilder, QosPolicyBuilder, TopicKind};
use serde_json::{Value, json};
use stage::{Process, Received, Stage, eventually, scenario};

/// Chromium, driven by `tests/browser/browser.py`.
struct Browser {
    child: Child,
    /// Its end ends the driver and the browser.
    commands: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Browser {
    /// A browser; `None`, having said so, where there is none.
    fn find() -> Option<Self> {
        let python = root().join(".venv/bin/python");
        let has_driver = Command::new(&python)
            .args(["-c", "import selenium"])
            .stderr(Stdio::null())
            .status();
        if !has_driver.is_ok_and(|status| status.success()) {
            skip(&format!("there is no {} with selenium", python.display()));
            return None;
        }
        for program in ["/usr/bin/chromium", "/usr/bin/chromedriver"] {
            if !Path::new(program).exists() {
                skip(&format!("there is no {program}"));
                return None;
            }
        }
        let mut child = Command::new(python)
            .arg(root().join("tests/browser/browser.py"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        Some(Self {
            commands: child.stdin.take(),
            answers: BufReader::new(child.stdout.take().unwrap()),
            child,
        })
    }

    fn ask(&mut self, command: &Value) -> Result<Value, String> {
        writeln!(self.commands.as_mut().unwrap(), "{command}").unwrap();
        let mut line = String::new();
        self.answers.read_line(&mut line).unwrap();
        let answer: Value = serde_json::from_str(&line).unwrap();
        match answer.get("error") {
            Some(error) => Err(error.to_string()),
            None => Ok(answer["is"].clone()),
        }
    }

    fn open(&mut self, address: &str) {
        self.ask(&json!({"open": address})).unwrap();
    }

    fn run(&mut self, script: &str) -> Value {
        self.ask(&json!({"run": script})).unwrap()
    }

    /// The text of the element, on one line.
    fn text(&mut self, selector: &str) -> String {
        let script = format!("return document.querySelector({selector:?})?.textContent ?? ''");
        self.run(&script).as_str().unwrap_or_default().to_owned()
    }

    /// Waits until the text of the element holds `part`, and returns it.
    fn until_text(&mut self, selector: &str, part: &str) -> String {
        let mut last = String::new();
        eventually(&format!("{selector} has '{part}'"), || {
            let text = self.text(selector);
            if text != last {
                println!("{selector}: {text}");
            }
            last = text;
            last.contains(part).then(|| last.clone())
        })
    }

    /// Clicks the button of that name within the element.
    fn click(&mut self, within: &str, name: &str) {
        let script = format!(
            "const all = [...document.querySelectorAll({:?})];
             const wanted = all.find((it) => it.textContent === {name:?});
             wanted?.click();
             return Boolean(wanted)",
            format!("{within} button")
        );
        eventually(&format!("a button '{name}' in {within}"), || {
            self.run(&script).as_bool()?.then_some(())
        });
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        drop(self.commands.take());
        let _ = self.child.wait();
    }
}

/// A vehicle in real time with its controller and actuator.
fn vehicle(stage: &Stage) -> [Process; 3] {
    [
        stage.node("plant_sim", &["initial_depth:=1.0"]),
        stage.node("dha_actuator", &[]),
        stage.node("depth_controller", &["depth_setpoint:=1.0"]),
    ]
}

/// The column of the first chart up to which its first trace is drawn.
const PEN: &str = "
    const canvas = document.querySelector('#charts canvas');
    const { width, height } = canvas;
    const pixels = canvas.getContext('2d').getImageData(0, 0, width, height).data;
    const ink = getComputedStyle(document.documentElement).getPropertyValue('--c1').trim();
    const parts = [1, 3, 5].map((at) => parseInt(ink.slice(at, at + 2), 16));
    for (let x = width - 1; x >= 0; x -= 1)
      for (let y = 0; y < height; y += 1)
        if (parts.every((part, k) => Math.abs(part - pixels[4 * (y * width + x) + k]) < 8)) return x;
    return -1";

const SAMPLES: &str =
    "return import('/charts.js').then((it) => it.samples('/auv/state:depth').times.length)";

#[test]
fn a_page_shows_a_vehicle_sets_a_gain_flies_a_manoeuvre_and_tells_of_a_node_that_died() {
    let Some(mut browser) = Browser::find() else {
        return;
    };
    let stage = Stage::new();
    let [_plant, actuator, _controller] = vehicle(&stage);
    let operator = stage.operator();
    let (_watch, page) = watch(&stage);
    browser.ask(&json!({"size": [1400, 1000]})).unwrap();
    browser.open(&page.address());

    // The charts move.
    browser.until_text("#attitude", "depth ");
    let samples = |browser: &mut Browser| browser.run(SAMPLES).as_u64().unwrap();
    let before = samples(&mut browser);
    let pen = |browser: &mut Browser| browser.run(PEN).as_i64().unwrap();
    let place = pen(&mut browser);
    eventually("more samples, and they are drawn", || {
        let came = samples(&mut browser) > before + 20;
        (came && pen(&mut browser) > place).then_some(())
    });

    // A stretch of time that is marked with the mouse fills the charts, which stand still until they are to follow again.
    browser
        .ask(&json!({"drag": [[300, 140], [400, 140]]}))
        .unwrap();
    browser.until_text("#pause", "Follow");
    let width = browser.run("return import('/charts.js').then((it) => it.seenWidth())");
    assert!(
        width.as_f64().is_some_and(|it| it > 0.0 && it < 60.0),
        "{width}"
    );
    browser.click("#recorder", "Follow");

    // A gain that is set on the page is the node's; one out of range is refused in place.
    let row = "[data-name='depth.p']";
    let set = |browser: &mut Browser, text: &str| {
        browser.run(&format!(
            "const row = document.querySelector(\"{row}\");
             row.querySelector('input').value = {text:?};
             row.querySelector('form').requestSubmit()"
        ));
    };
    let node = "details summary";
    browser.until_text("#parameters", "/auv/depth_controller");
    browser.run(&format!(
        "[...document.querySelectorAll({node:?})].find((it) => it.textContent === '/auv/depth_controller').click()"
    ));
    browser.until_text(&format!("{row} small"), "[rad/m]");
    set(&mut browser, "-1");
    browser.until_text(&format!("{row} output"), "must lie in");
    set(&mut browser, "much");
    browser.until_text(&format!("{row} output"), "not a number");
    set(&mut browser, "1.25");
    browser.until_text(&format!("{row} output"), "set");
    let get = operator
        .rt
        .client::<GetParameters>("depth_controller/get_parameters");
    let names = vec!["depth.p".to_owned()];
    let values = operator
        .call(&get.unwrap(), GetParametersRequest { names })
        .values;
    assert_eq!(values[0].double_value, 1.25);

    // An angle is in degrees on the whole page, whatever unit it is set in; the node has radians.
    let limit = "[data-name='planes.limit']";
    let value = format!("return document.querySelector(\"{limit} input\").value");
    assert_eq!(browser.run(&value), json!("30"));
    browser.until_text(&format!("{limit} small"), "[deg] (from 0 to 90 deg");
    let set_limit = |browser: &mut Browser, text: &str| {
        browser.run(&format!(
            "const row = document.querySelector(\"{limit}\");
             row.querySelector('input').value = {text:?};
             row.querySelector('form').requestSubmit()"
        ));
    };
    set_limit(&mut browser, "2 m");
    browser.until_text(&format!("{limit} output"), "rad, deg");
    set_limit(&mut browser, "0.5 rad");
    browser.until_text(&format!("{limit} output"), "set");
    let names = vec!["planes.limit".to_owned()];
    let get = operator
        .rt
        .client::<GetParameters>("depth_controller/get_parameters");
    let values = operator
        .call(&get.unwrap(), GetParametersRequest { names })
        .values;
    assert!((values[0].double_value - 0.5).abs() < 1e-12);
    eventually("the value in degrees", || {
        let shown = browser.run(&value);
        shown.as_str()?.starts_with("28.64").then_some(())
    });
    let heads = browser.run(HEADS).to_string();
    assert!(
        heads.contains("Pitch [deg]") && heads.contains("Depth [m]"),
        "{heads}"
    );
    let panel = browser.text("#operate");
    assert!(
        panel.contains("pitch [deg]") && panel.contains("depth [m]"),
        "{panel}"
    );
    assert!(
        panel.contains("0.02 s"),
        "a fault's preset has its unit: {panel}"
    );

    // Nothing on it keeps people from using it, in light or dark colours, nor do programs talk to themselves.
    if let Some(axe) = browser::axe() {
        browser.run(&axe);
        for dark in [false, true] {
            browser.ask(&json!({"dark": dark})).unwrap();
            let script = format!(
                "return axe.run(document, {{ runOnly: {}, resultTypes: ['violations'] }}).then((it) =>
                 it.violations.map(({{ id, impact, nodes }}) => `${{impact}} ${{id}}: ${{nodes.map((it) => it.html.slice(0, 200)).join(' ')}}`))",
                browser::AXE_TAGS
            );
            assert_eq!(browser.run(&script), json!([]), "dark: {dark}");
        }
    }
    let diagnostics = browser.text("#diagnostics");
    assert!(!diagnostics.contains("claim"), "{diagnostics}");
    assert_eq!(browser.text("#log th"), "time of day");

    // A manoeuvre is flown and cancelled.
    browser.click("#operate", "Fly");
    browser.until_text("#progress", "running, ");
    browser.click("#operate", "Cancel");
    browser.until_text("#progress", "cancelled");

    // A setpoint moves the vehicle.
    browser.run(
        "const input = document.querySelector('[aria-label=\"depth setpoint\"]');
         input.value = '5ft';
         input.form.requestSubmit()",
    );
    operator.state("it dives", |state| state.depth > 1.02);

    // One above the surface, by the natural slip of z up, is refused with the reason.
    browser.run(
        "const input = document.querySelector('[aria-label=\"depth setpoint\"]');
         input.value = '-3';
         input.form.requestSubmit()",
    );
    let refusal = "depth setpoint -3.0 refused: the value must lie in [0, 10000] m, positive down";
    browser.until_text("#diagnostics", refusal);
    browser.until_text("#log", refusal);

    // A reset begins the charts anew, though time goes on.
    let begin = "return import('/charts.js').then((it) => it.samples('/auv/state:depth')).then((it) => [it.times[0], it.values[0]])";
    let began = browser.run(begin)[0].as_f64().unwrap();
    browser.click("#operate", "Reset the vehicle");
    eventually("the charts begin anew where the vehicle does", || {
        let begins = browser.run(begin);
        (begins[0].as_f64()? > began && begins[1] == json!(1)).then_some(())
    });

    // A fault is tried with a click.
    browser.click("#operate", "direction");
    browser.until_text("#diagnostics", "direction valve stuck");

    // The death of a node is told, and its return.
    actuator.kill();
    browser.until_text("#notice", "/auv/dha_actuator is silent");
    browser.until_text("#notice", "/auv/dha_actuator is gone");
    let _actuator = stage.node("dha_actuator", &[]);
    eventually("the notice goes", || {
        let notice = browser.text("#notice");
        (!notice.contains("dha_actuator")).then_some(())
    });
}

/// A vehicle at a depth, in real time, in a namespace of its own.
fn vehicle_in(stage: &Stage, namespace: &str, depth: f64) -> [Process; 3] {
    let place = format!("__ns:={namespace}");
    let start = |name: &str, parameters: &[&str]| {
        let parameters = parameters.iter().flat_map(|it| ["-p", *it]);
        let own = ["node", name, "--ros-args", "-r", &place];
        let arguments: Vec<&str> = own.into_iter().chain(parameters).collect();
        stage.start_as(&arguments, &[(planesman::nodes::LAUNCHED, "1")])
    };
    let (initial, setpoint) = (
        format!("initial_depth:={depth:?}"),
        format!("depth_setpoint:={depth:?}"),
    );
    [
        start("plant_sim", &[&initial]),
        start("dha_actuator", &[]),
        start("depth_controller", &[&setpoint]),
    ]
}

/// Where the charts' lines are: title, and of each trace its text.
const HEADS: &str = "return [...document.querySelectorAll('.chart .head')].map((it) =>
    [it.querySelector('b').textContent, ...[...it.querySelectorAll('.key')].map((key) => key.textContent)].join('|'))";

#[test]
fn two_vehicles_are_shown_by_turns_and_over_each_other_and_do_not_mix() {
    let Some(mut browser) = Browser::find() else {
        return;
    };
    let stage = Stage::new();
    let _first = vehicle_in(&stage, "/north", 1.5);
    let [_plant, actuator, _controller] = vehicle_in(&stage, "/south", 3.5);
    let (_watch, page) = watch(&stage);
    browser.ask(&json!({"size": [1400, 1000]})).unwrap();
    browser.open(&format!("{}#/south", page.address()));
    let choose = |browser: &mut Browser, name: &str| {
        eventually(&format!("{name} is listed"), || {
            let script = format!(
                "const list = document.querySelector('#vehicle');
                 const listed = [...list.options].some((it) => it.value === {name:?});
                 if (listed && list.value !== {name:?}) {{ list.value = {name:?}; list.dispatchEvent(new Event('change')); }}
                 return listed"
            );
            browser.run(&script).as_bool()?.then_some(())
        });
    };
    for name in ["/north", "/south"] {
        browser.until_text("#vehicle", name);
    }
    for (name, depth, other) in [
        ("/south", "depth 3.", "/north"),
        ("/north", "depth 1.", "/south"),
    ] {
        choose(&mut browser, name);
        browser.until_text("#attitude", depth);
        browser.until_text(".chart .head", depth);
        for table in ["#nodes", "#topics", "#parameters", "#diagnostics", "#log"] {
            let own = if table == "#log" { &name[1..] } else { name };
            let text = browser.until_text(table, own);
            assert!(!text.contains(other), "{table} of {name}: {text}");
            assert!(!text.contains(&format!("{}.", &other[1..])), "{text}");
        }
        let hash = browser.run("return location.hash");
        assert_eq!(hash, json!(format!("#{name}")));
    }

    // What is set and sent is the chosen one's: the other stays where it is.
    browser.run(
        "const input = document.querySelector('[aria-label=\"depth setpoint\"]');
         input.value = '1.75';
         input.form.requestSubmit()",
    );
    let heads = |browser: &mut Browser| {
        let heads = browser.run(HEADS);
        let heads = heads.as_array().cloned().unwrap_or_default();
        let text = |it: Value| it.as_str().unwrap_or_default().to_owned();
        heads.into_iter().map(text).collect::<Vec<String>>()
    };
    eventually("its setpoint", || {
        heads(&mut browser)[0]
            .contains("setpoint 1.75")
            .then_some(())
    });

    // All over each other: a line for each, and every table has both.
    browser.run("document.querySelector('#all').click()");
    eventually("both in each chart", || {
        let heads = heads(&mut browser);
        let depth = heads.first()?;
        let parts: Vec<&str> = depth.split('|').collect();
        (parts.len() == 3
            && parts[0] == "Depth: depth [m]"
            && parts[1].starts_with("/north 1.")
            && parts[2].starts_with("/south 3."))
        .then_some(())
    });
    for table in ["#nodes", "#topics", "#parameters", "#diagnostics"] {
        browser.until_text(table, "/north/");
        browser.until_text(table, "/south/");
    }

    // One that is not operated is told as lost too, and what it did stays.
    actuator.kill();
    browser.until_text("#vehicle", "/south (1 node lost)");
    let last = heads(&mut browser);
    assert!(last[0].contains("/south 3."), "{last:?}");
}

#[test]
fn a_page_whose_program_ended_says_so_and_goes_on_with_the_next_one() {
    let Some(mut browser) = Browser::find() else {
        return;
    };
    let stage = Stage::new();
    let _nodes = vehicle(&stage);
    let (watch, page) = watch(&stage);
    browser.open(&page.address());
    browser.until_text("#attitude", "depth ");
    watch.kill();
    browser.until_text("#connection", "no connection");
    let before = browser.run(SAMPLES).as_u64().unwrap();
    let (_, port) = page.host.rsplit_once(':').unwrap();
    let again = stage.start_as(
        &["watch", "--no-open", "--port", port],
        &[(planesman::nodes::LAUNCHED, "1")],
    );
    // It has another token, which the page has once the browser has been told.
    let next = Page::of(&again);
    assert_ne!(next.token, page.token);
    browser.until_text("#notice", "This page needs the token");
    browser.ask(&json!({"tab": next.address()})).unwrap();
    browser.until_text("#connection", "connected");
    eventually("samples before and after", || {
        (browser.run(SAMPLES).as_u64()? > before + 10).then_some(())
    });
}

/// A participant that publishes a topic of a name that no ROS node would give.
fn strange_topic(domain: u16, name: &str) -> impl Sized + use<> {
    let builder = DomainParticipantBuilder::new(domain).with_only_networks([Ipv4Addr::LOCALHOST]);
    let participant = builder.build().unwrap();
    let qos = QosPolicyBuilder::new().build();
    let type_name = Float64::DDS_TYPE_NAME.to_owned();
    let topic = participant
        .create_topic(name.to_owned(), type_name, &qos, TopicKind::NoKey)
        .unwrap();
    let publisher = participant.create_publisher(&qos).unwrap();
    let writer = publisher
        .create_datawriter_no_key_cdr::<f64>(&topic, None)
        .unwrap();
    (writer, publisher, participant)
}

#[test]
fn a_script_in_a_topics_name_in_the_log_or_in_the_diagnostics_stays_text() {
    let Some(mut browser) = Browser::find() else {
        return;
    };
    const SCRIPT: &str = "<img src=x onerror=window.ran=1>";
    let stage = Stage::new();
    let operator = stage.operator();
    let _participant = strange_topic(stage.domain(), "rt/<script>window.ran=1</script>");
    let (_watch, page) = watch(&stage);
    browser.open(&page.address());
    browser.until_text("#topics", "<script>window.ran=1</script>");
    let log = operator
        .rt
        .publisher::<Log>("/rosout", Qos::latched(10))
        .unwrap();
    log.publish(&Log {
        level: Log::ERROR,
        name: SCRIPT.to_owned(),
        msg: SCRIPT.to_owned(),
        ..Log::default()
    });
    let diagnostics = operator
        .rt
        .publisher("/diagnostics", Qos::reliable(10))
        .unwrap();
    let status = DiagnosticStatus {
        name: SCRIPT.to_owned(),
        message: SCRIPT.to_owned(),
        ..DiagnosticStatus::default()
    };
    let array = DiagnosticArray {
        status: vec![status],
        ..DiagnosticArray::default()
    };
    browser.until_text("#log", SCRIPT);
    eventually("the status on the page", || {
        diagnostics.publish(&array);
        browser.text("#diagnostics").contains(SCRIPT).then_some(())
    });
    assert_eq!(browser.run("return window.ran ?? null"), Value::Null);
    assert_eq!(
        browser.run("return document.querySelectorAll('img').length"),
        json!(0)
    );
}

#[test]
fn only_the_page_itself_is_answered() {
    let stage = Stage::new();
    let (_watch, page) = watch(&stage);
    let [host, cookie, origin] = page.own();
    let first = page.answer(&format!("GET /?token={}", page.token), &[&host], "");
    assert!(first.starts_with("HTTP/1.1 200"), "{first}");
    let value = cookie.strip_prefix("Cookie: ").unwrap();
    for part in [
        &format!("set-cookie: {value}; HttpOnly; SameSite=Strict; Path=/\r\n"),
        "content-security-policy: default-src 'self'",
        "frame-ancestors 'none'",
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
        "cross-origin-resource-policy: same-origin",
        "cache-control: no-store",
    ] {
        assert!(first.contains(part), "{part}: {first}");
    }
    assert!(
        !first.contains("http://") && !first.contains("https://"),
        "{first}"
    );

    // Nothing is answered without the token, to nobody.
    let routes = [
        "GET /",
        "GET /main.js",
        "GET /charts",
        "GET /units",
        "GET /events",
        "GET /bag?node=/auv/recorder",
        "HEAD /",
        "GET /nothing",
        "POST /do",
    ];
    let wrong = format!("{cookie}0");
    for route in routes {
        for headers in [&[host.as_str(), &origin][..], &[&host, &origin, &wrong]] {
            let answer = page.answer(route, headers, "");
            assert!(answer.starts_with("HTTP/1.1 401"), "{route}: {answer}");
        }
        // Nor with it, to a page of another origin.
        for foreign in [
            "Sec-Fetch-Site: cross-site",
            "Sec-Fetch-Site: same-site",
            "Origin: http://elsewhere.example",
            "Origin: null",
        ] {
            let answer = page.answer(route, &[&host, &cookie, foreign], "");
            assert!(
                answer.starts_with("HTTP/1.1 403"),
                "{route}, {foreign}: {answer}"
            );
        }
        let other = page.answer(route, &["Host: rebound.example", &cookie], "");
        assert!(other.starts_with("HTTP/1.1 421"), "{route}: {other}");
    }
    for headers in [
        &[host.as_str(), &cookie][..],
        &[&host, &cookie, "Sec-Fetch-Site: same-origin"],
        &[&host, &cookie, "Sec-Fetch-Site: none"],
    ] {
        let answer = page.answer("GET /charts", headers, "");
        assert!(answer.starts_with("HTTP/1.1 200"), "{headers:?}: {answer}");
    }

    let json = "Content-Type: application/json";
    let body = r#"{"do":"parameters","node":"/nobody"}"#;
    let asked = page.post(body);
    assert!(asked.starts_with("HTTP/1.1 200"), "{asked}");
    assert!(asked.contains("no node serves /nobody/"), "{asked}");
    let without_origin = page.answer("POST /do", &[&host, &cookie, json], body);
    assert!(
        without_origin.starts_with("HTTP/1.1 403"),
        "{without_origin}"
    );
    // A form of another page can send no JSON.
    let text = "Content-Type: text/plain";
    let form = page.answer("POST /do", &[&host, &cookie, &origin, text], body);
    assert!(form.starts_with("HTTP/1.1 415"), "{form}");
    for body in ["", "{", r#"{"do":"shutdown"}"#, &"[".repeat(60_000)] {
        let refused = page.post(body);
        assert!(refused.starts_with("HTTP/1.1 4"), "{refused}");
    }
    let bag = page.get("/bag?node=/auv/recorder");
    assert!(bag.starts_with("HTTP/1.1 404"), "{bag}");
}

#[test]
fn the_token_is_in_what_the_browser_opens_and_in_no_command_line() {
    let stage = Stage::new();
    // What is opened, as a desktop does.
    let opened = stage.path("opened");
    let script = format!("#!/bin/sh\necho \"$@\" > {opened}.part; mv {opened}.part {opened}\n");
    let opener = stage.file("xdg-open", script);
    fs::set_permissions(&opener, fs::Permissions::from_mode(0o755)).unwrap();
    let folder = Path::new(&opener).parent().unwrap().to_str().unwrap();
    let program = stage.start_as(
        &["watch"],
        &[
            (planesman::nodes::LAUNCHED, "1"),
            ("PATH", &format!("{folder}:/usr/bin:/bin")),
            ("DISPLAY", ":7"),
            ("XDG_RUNTIME_DIR", folder),
        ],
    );
    let page = Page::of(&program);
    let arguments = eventually("the browser", || fs::read_to_string(&opened).ok());
    let file = Path::new(arguments.trim());
    assert!(!arguments.contains(&page.token), "{arguments}");
    let mode = fs::metadata(file).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
    let text = fs::read_to_string(file).unwrap();
    assert!(
        text.contains(&format!("url={}\"", page.address())),
        "{text}"
    );
    if let Some(mut browser) = Browser::find() {
        browser.open(&format!("file://{}", file.display()));
        browser.until_text("#connection", "connected");
        // The address bar has no token, and a reload needs none.
        let address = browser.run("return location.href");
        assert_eq!(address, json!(format!("http://{}/", page.host)));
        browser.run("location.reload()");
        browser.until_text("#connection", "connected");
    }
    program.press_ctrl_c();
    let outcome = program.finish().success();
    assert!(!outcome.stderr.contains(&page.token), "{}", outcome.stderr);
    assert!(!file.exists(), "the file is still there");
}

/// A server that answers each request with an empty page, and tells of it.
fn strange_server() -> (u16, Receiver<String>) {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let port = listener.local_addr().unwrap().port();
    let (sender, heads) = channel();
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let (mut stream, sender) = (stream.unwrap(), sender.clone());
            std::thread::spawn(move || {
                let reader = BufReader::new(stream.try_clone().unwrap());
                let lines = reader.lines().map_while(Result::ok);
                let head: Vec<String> = lines.take_while(|line| !line.is_empty()).collect();
                let _ = sender.send(head.join("\r\n"));
                let _ = stream.write_all(
                    b"HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nConnection: close\r\n\r\n<!doctype html><title>elsewhere</title>",
                );
            });
        }
    });
    (port, heads)
}

/// Everything by which a page can make a browser send a request to another origin; what came of each.
const ATTACK: &str = "
    const tried = (begin) => new Promise((done) => { begin(done); setTimeout(() => done('nothing'), 3000); });
    const element = (tag, properties) => tried((done) => document.head.append(
        Object.assign(document.createElement(tag), properties, { onload: () => done('loaded'), onerror: () => done('refused') })));
    const asked = (path, options) => fetch(TARGET + path, { mode: 'no-cors', credentials: 'include', ...options }).then(() => 'sent', () => 'refused');
    const body = JSON.stringify({ do: 'publish', topic: '/auv/depth_setpoint', text: '2' });
    const form = document.createElement('form');
    const frame = Object.assign(document.createElement('iframe'), { name: 'frame' });
    document.body.append(frame, form);
    Object.assign(form, { method: 'POST', action: TARGET + '/do', enctype: 'text/plain', target: 'frame' });
    form.append(Object.assign(document.createElement('input'), { name: body, value: '' }));
    form.submit();
    navigator.sendBeacon(TARGET + '/do', body);
    return Promise.all([
        element('script', { src: TARGET + '/uPlot.js' }),
        element('link', { rel: 'stylesheet', href: TARGET + '/watch.css' }),
        element('img', { src: TARGET + '/bag?node=/auv/recorder' }),
        tried((done) => { new EventSource(TARGET + '/events?channel=/a:b', { withCredentials: true }).onerror = () => done('refused'); }),
        asked('/events?channel=/a:b'), asked('/charts'), asked('/'),
        asked('/do', { method: 'POST', body }),
        asked('/do', { method: 'POST', body, mode: 'cors', headers: { 'Content-Type': 'application/json' } }),
    ])";

#[test]
fn a_page_of_another_origin_in_the_same_browser_gets_nothing_and_does_nothing() {
    let Some(mut browser) = Browser::find() else {
        return;
    };
    let stage = Stage::new();
    let operator = stage.operator();
    let (seen, setpoints) = channel();
    let on_setpoint = move |it: Float64| {
        let _ = seen.send(it.data);
        Received::Parameters
    };
    let qos = Qos::reliable(10);
    operator
        .rt
        .subscribe("depth_setpoint", qos, on_setpoint)
        .unwrap();
    let (_watch, page) = watch(&stage);
    browser.open(&page.address());
    browser.until_text("#connection", "connected");

    // Another port of the same address, to which the browser sends the page's cookie; and another name.
    let (elsewhere, _) = strange_server();
    let (mirror, heads) = strange_server();
    let mut with_cookie = 0;
    for place in ["127.0.0.1", "localhost"] {
        browser.open(&format!("http://{place}:{elsewhere}/"));
        let mut attack =
            |target: &str| browser.run(&ATTACK.replace("TARGET", &format!("'{target}'")));
        let came = attack(&format!("http://{}", page.host));
        println!("from {place}: {came}");
        for (k, outcome) in came.as_array().unwrap()[..4].iter().enumerate() {
            assert_eq!(*outcome, json!("refused"), "{k}: {came}");
        }
        // What the browser sends to such a target is what is refused, word for word.
        attack(&format!("http://127.0.0.1:{mirror}"));
        let own = format!("Host: 127.0.0.1:{mirror}");
        let sent: Vec<String> = heads.try_iter().filter(|it| !it.is_empty()).collect();
        assert!(sent.len() > 8, "{sent:?}");
        for head in sent {
            assert!(head.contains(&own), "{head}");
            with_cookie += usize::from(head.contains(&page.cookie()["Cookie: ".len()..]));
            let again = head.replace(&own, &format!("Host: {}", page.host));
            let mut stream = page.send(&format!("{again}\r\n\r\n"));
            let mut status = [0; 12];
            stream.read_exact(&mut status).unwrap();
            assert_eq!(&status, b"HTTP/1.1 403", "{again}");
        }
        // A link to the page is no way in without the token.
        browser.run(&format!("location.href = 'http://{}/'", page.host));
        browser.until_text("body", "open the address that planesman watch printed");
    }
    assert!(
        with_cookie > 8,
        "the cookie was sent {with_cookie} times only"
    );

    // Nobody was commanded; the page itself can.
    browser.open(&format!("http://{}/", page.host));
    browser.until_text("#connection", "connected");
    let own = r#"return fetch('/do', { method: 'POST', headers: { 'Content-Type': 'application/json' },
        body: JSON.stringify({ do: 'publish', topic: '/auv/depth_setpoint', text: '3' }) }).then((it) => it.json())"#;
    assert_eq!(browser.run(own)["ok"], json!(true));
    let first = eventually("the page's setpoint", || {
        let _ = operator.rt.next(Duration::from_millis(10));
        setpoints.try_recv().ok()
    });
    assert_eq!(first, 3.0);
}

#[test]
fn a_dive_shows_its_page_and_takes_it_along_when_it_ends() {
    let stage = Stage::new();
    let file = stage.file(
        "short.yaml",
        scenario(600.0, "  depth_controller: {depth_setpoint: 1.0}"),
    );
    let operator = stage.operator();
    let dive = stage.start(&["dive", &file, "--watch", "--keep-running"]);
    let page = Page::of(&dive);
    let shown = page.get("/");
    assert!(shown.starts_with("HTTP/1.1 200"), "{shown}");
    operator.state("the vehicle flies", |state| state.depth > 0.01);
    dive.press_ctrl_c();
    dive.finish().success();
    assert!(
        TcpStream::connect(&page.host).is_err(),
        "the page is still there"
    );
}
