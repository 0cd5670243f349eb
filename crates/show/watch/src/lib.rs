//! Web page that shows the vehicles of a DDS domain.
//!
//! | module | contents |
//! |---|---|
//! | [`run`], [`Options`] | the program: a node and a server |
//! | `node` | the node: topics read, services called, manoeuvres flown |
//! | `feeds` | numbers from messages of any type |
//! | `nodes` | which nodes are alive |
//! | `error` | [`Error`] |
//! | `command` | requests of a page |
//! | `board`, `series` | the page's data, and its updates |
//! | `charts` | the default charts |
//! | `units` | the page's unit of each quantity |
//! | [`ModelFunctions`] | poles and vehicles, computed by the program |
//! | `server`, `guard`, `visitors` | HTTP; authentication; limits of connections |
//! | `bag_file` | the recorder's file, for download |
//! | `page/` | the page itself: HTML, CSS and JavaScript without a build step |
//!
//! The node runs on the thread that calls [`run`], the server on a separate thread. The node writes to the board; each page's event stream reads the
//! board about thirty times a second. A slow page gets larger messages and delays nobody else.

mod bag_file;
mod board;
mod charts;
mod command;
mod error;
mod feeds;
mod guard;
mod models;
mod node;
mod nodes;
mod series;
mod server;
mod units;
mod visitors;

use std::io::Write as _;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use planesman_node::{Domain, NodeSpec, ReceiveLimits, RosArguments, Runtime};
use tempfile::NamedTempFile;

pub use error::Error;
pub use models::{ModelFunctions, Named, Pole, Vehicle};
use node::{Event, Watch};

/// Options of the page's server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Address to listen on.
    pub listen: IpAddr,
    /// Port; 0 for any free port.
    pub port: u16,
    /// Whether to open the browser.
    pub open: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            listen: Ipv4Addr::LOCALHOST.into(),
            port: 0,
            open: true,
        }
    }
}

/// Serves the page and runs its node until the process is requested to stop.
///
/// # Errors
/// The address cannot be listened on, or the middleware does not start.
pub fn run(options: Options, models: ModelFunctions, arguments: RosArguments) -> Result<(), Error> {
    let board = board::SharedBoard::default();
    let (requests, asked) = smol::channel::bounded(64);
    let address = SocketAddr::new(options.listen, options.port);
    let server = server::Server::bind(address, board.clone(), requests)?;
    let (rt, ()) = Runtime::with_receive_limits(
        Domain::from_environment()?,
        NodeSpec {
            name: "planesman_watch",
            namespace: "/",
            validate: |(): &()| Ok(()),
            on_parameters: |_| Event::Parameters,
        },
        arguments,
        |()| ReceiveLimits::any(32 << 20),
    )?;
    let mut watch = Watch::new(&rt, board, asked, models)?;
    let page = server.page();
    planesman_console::out!("{page}")?;
    server.start()?;
    // It is there as long as the program: a browser may take its time.
    let _opened = if options.open { open(&page) } else { None };
    rt.run(move |rt, event| Ok(watch.on(rt, event)))
}

/// Opens the page in the user's browser; without a browser the user opens the printed address. Without a display no browser is opened, because it would
/// run in the terminal and hide this program's output.
///
/// Every user of the machine can see a program's arguments. So the browser gets a file of mode 0600 that redirects to the address.
fn open(page: &str) -> Option<NamedTempFile> {
    let displays = ["DISPLAY", "WAYLAND_DISPLAY"];
    if displays.iter().all(|it| std::env::var_os(it).is_none()) {
        return None;
    }
    let own = std::env::var_os("XDG_RUNTIME_DIR").map_or_else(std::env::temp_dir, PathBuf::from);
    let file = tempfile::Builder::new()
        .prefix("planesman_watch_")
        .suffix(".html")
        .tempfile_in(own);
    let mut file = file.ok()?;
    writeln!(
        file,
        "<!doctype html><meta charset=\"utf-8\"><title>Planesman</title>\
         <meta http-equiv=\"refresh\" content=\"0; url={page}\"><a href=\"{page}\">Planesman</a>"
    )
    .ok()?;
    let mut opener = Command::new("xdg-open")
        .arg(file.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    // Without a thread nobody takes note of its end.
    let _ = std::thread::Builder::new().spawn(move || opener.wait());
    Some(file)
}
