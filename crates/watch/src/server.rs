//! HTTP: the page, its stream of events, and what it asks for.

use std::io::Read as _;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use axum::Router;
use axum::body::Body;
use axum::extract::rejection::JsonRejection;
use axum::extract::{DefaultBodyLimit, Json, RawQuery, Request as HttpRequest, State};
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::sse::{Event, Sse};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::{get, post};
use futures::Stream;
use serde_json::Value;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use tokio::time::MissedTickBehavior;

use crate::board::{Reader, SharedBoard, locked};
use crate::charts;
use crate::command::{Command, Request, refused};
use crate::guard::{COOKIE, Guard, query_token};
use crate::units;

/// Time between two messages to a page: thirty a second.
const FRAME: Duration = Duration::from_millis(33);
/// Longest time between two messages to a page.
const QUIET: Duration = Duration::from_secs(5);
/// Pages that are open at once, and requests under way at once.
const PAGES: usize = 32;
const REQUESTS: usize = 64;
/// Channels of one page.
const CHANNELS: usize = 256;
/// The longest request, bytes.
const LONGEST_REQUEST: usize = 1 << 16;

/// Nothing but the page's own files is loaded or run, and no other page shows it within itself.
const POLICY: &str = "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; \
                      form-action 'none'; frame-ancestors 'none'";

/// The files of the page: path, type and text.
const FILES: &[(&str, &str, &str)] = &[
    ("/", HTML, include_str!("../page/index.html")),
    ("/watch.css", CSS, include_str!("../page/watch.css")),
    ("/main.js", SCRIPT, include_str!("../page/main.js")),
    ("/charts.js", SCRIPT, include_str!("../page/charts.js")),
    ("/views.js", SCRIPT, include_str!("../page/views.js")),
    ("/operate.js", SCRIPT, include_str!("../page/operate.js")),
    ("/tables.js", SCRIPT, include_str!("../page/tables.js")),
    ("/dom.js", SCRIPT, include_str!("../page/dom.js")),
    (
        "/uPlot.js",
        SCRIPT,
        include_str!("../../plot/uplot/uPlot.iife.min.js"),
    ),
    (
        "/uPlot.css",
        CSS,
        include_str!("../../plot/uplot/uPlot.min.css"),
    ),
];
const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// What the handlers share.
#[derive(Clone)]
struct Shared {
    board: SharedBoard,
    requests: smol::channel::Sender<Request>,
    guard: Arc<Guard>,
    pages: Arc<Semaphore>,
    under_way: Arc<Semaphore>,
}

/// A server that listens, and does not answer yet.
pub(crate) struct Server {
    listener: TcpListener,
    address: SocketAddr,
    shared: Shared,
}

impl Server {
    pub(crate) fn bind(
        address: SocketAddr,
        board: SharedBoard,
        requests: smol::channel::Sender<Request>,
    ) -> Result<Self> {
        let listener =
            TcpListener::bind(address).with_context(|| format!("cannot listen at {address}"))?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            address: listener.local_addr()?,
            listener,
            shared: Shared {
                board,
                requests,
                guard: Arc::new(Guard::of(address.ip())?),
                pages: Arc::new(Semaphore::new(PAGES)),
                under_way: Arc::new(Semaphore::new(REQUESTS)),
            },
        })
    }

    /// The page's address, with the token if one is needed.
    pub(crate) fn page(&self) -> String {
        match &self.shared.guard.token {
            Some(token) => format!("http://{}/?token={token}", self.address),
            None => format!("http://{}/", self.address),
        }
    }

    /// Answers from now on, on a thread of its own.
    pub(crate) fn start(self) -> Result<()> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .build()?;
        let serve = move || {
            let served = runtime.block_on(async {
                let listener = tokio::net::TcpListener::from_std(self.listener)?;
                axum::serve(listener, routes(self.shared)).await
            });
            if let Err(error) = served {
                log::error!("the page is not served any more: {error}");
            }
        };
        std::thread::Builder::new()
            .name("page".to_owned())
            .spawn(serve)?;
        Ok(())
    }
}

fn routes(shared: Shared) -> Router {
    let mut router = Router::new();
    for (path, content_type, text) in FILES {
        let file = move || async move { ([(header::CONTENT_TYPE, *content_type)], *text) };
        router = router.route(path, get(file));
    }
    router
        .route("/charts", get(|| async { Json(charts::CHARTS) }))
        .route("/side_view", get(|| async { Json(charts::SIDE_VIEW) }))
        .route("/setpoints", get(|| async { Json(charts::SETPOINTS) }))
        .route("/units", get(|| async { Json(units::told()) }))
        .route("/events", get(events))
        .route("/do", post(execute))
        .route("/bag", get(bag))
        .layer(DefaultBodyLimit::max(LONGEST_REQUEST))
        .layer(from_fn_with_state(shared.clone(), admit))
        .with_state(shared)
}

/// Answers only who may ask, and says to the browser what the page may do.
async fn admit(State(shared): State<Shared>, request: HttpRequest, next: Next) -> Response {
    let (headers, query) = (request.headers(), request.uri().query());
    let changes = !matches!(*request.method(), Method::GET | Method::HEAD);
    let mut response = match shared.guard.admit(headers, changes) {
        Err(refusal) => refusal.into_response(),
        Ok(()) if !shared.guard.knows(headers, query) => (
            StatusCode::UNAUTHORIZED,
            "this page needs the token in the address that planesman watch has printed\n",
        )
            .into_response(),
        // The token goes into a cookie, and out of the address bar.
        Ok(()) if query_token(query).is_some() && request.uri().path() == "/" => {
            with_cookie(Redirect::to("/").into_response(), &shared.guard)
        }
        Ok(()) => next.run(request).await,
    };
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
    }
    response
}

fn with_cookie(mut response: Response, guard: &Guard) -> Response {
    let token = guard.token.as_deref().unwrap_or_default();
    let cookie = format!("{COOKIE}={token}; HttpOnly; SameSite=Strict; Path=/");
    if let Ok(cookie) = HeaderValue::try_from(cookie) {
        response.headers_mut().insert(header::SET_COOKIE, cookie);
    }
    response
}

/// The stream of a page: what is new of the channels in `?channel=A&channel=B` and of everything else, thirty times a second.
async fn events(
    State(shared): State<Shared>,
    RawQuery(query): RawQuery,
) -> Result<Sse<impl Stream<Item = Result<Event, axum::Error>>>, Response> {
    let permit = Arc::clone(&shared.pages).try_acquire_owned();
    let permit = permit.map_err(|_| busy("too many pages are open"))?;
    let channels: Vec<String> = values(query.as_deref(), "channel").take(CHANNELS).collect();
    let keep = Command::Keep {
        channels: channels.clone(),
    };
    let told = ask(&shared, keep).await;
    let refused = told["refused"].as_array().cloned().unwrap_or_default();
    {
        let mut board = locked(&shared.board);
        for (name, reason) in channels.iter().zip(&refused) {
            if let Some(reason) = reason.as_str() {
                board.channel(name).refusal = Some(reason.to_owned());
            }
        }
    }
    let mut timer = tokio::time::interval(FRAME);
    timer.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let stream = Streamed {
        reader: Reader::of(channels.into_iter()),
        board: shared.board,
        timer,
        _permit: permit,
    };
    Ok(Sse::new(futures::stream::unfold(stream, async |mut it| {
        let event = it.next().await;
        Some((event, it))
    })))
}

/// One page's stream.
struct Streamed {
    reader: Reader,
    board: SharedBoard,
    timer: tokio::time::Interval,
    _permit: OwnedSemaphorePermit,
}

impl Streamed {
    async fn next(&mut self) -> Result<Event, axum::Error> {
        let since = Instant::now();
        loop {
            self.timer.tick().await;
            let message = self.reader.news(&locked(&self.board));
            // An empty message says that the connection is there.
            if !message.is_empty() || since.elapsed() > QUIET {
                return Event::default().json_data(message);
            }
        }
    }
}

/// The values of that name in an address.
fn values<'a>(query: Option<&'a str>, name: &'a str) -> impl Iterator<Item = String> + use<'a> {
    form_urlencoded::parse(query.unwrap_or_default().as_bytes())
        .filter(move |(key, _)| key == name)
        .map(|(_, value)| value.into_owned())
}

/// Hands a request to the node and waits for its answer.
async fn ask(shared: &Shared, command: Command) -> Value {
    let (reply, answered) = oneshot::channel();
    let request = Request { command, reply };
    if shared.requests.send(request).await.is_err() {
        return refused("the node has stopped");
    }
    answered
        .await
        .unwrap_or_else(|_| refused("the node has stopped"))
}

/// Does what a page asks for.
async fn execute(
    State(shared): State<Shared>,
    body: Result<Json<Command>, JsonRejection>,
) -> Response {
    let Ok(_permit) = shared.under_way.try_acquire() else {
        return busy("too many requests are under way");
    };
    match body {
        Ok(Json(command)) => Json(ask(&shared, command).await).into_response(),
        Err(rejection) => {
            (rejection.status(), Json(refused(rejection.body_text()))).into_response()
        }
    }
}

fn busy(text: &'static str) -> Response {
    (StatusCode::SERVICE_UNAVAILABLE, Json(refused(text))).into_response()
}

/// The file that a recorder writes now, as far as it is written.
async fn bag(State(shared): State<Shared>, RawQuery(query): RawQuery) -> Response {
    /// How an MCAP file begins: whatever path a diagnostic names, nothing else is handed out.
    const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
    let node = values(query.as_deref(), "node").next().unwrap_or_default();
    let command = Command::Bag { node };
    let told = ask(&shared, command).await;
    let Some(path) = told["file"].as_str() else {
        return (StatusCode::NOT_FOUND, Json(told)).into_response();
    };
    let opened = std::fs::File::open(path).and_then(|mut file| {
        let mut magic = [0; MAGIC.len()];
        file.read_exact(&mut magic)?;
        let length = file.metadata()?.len();
        Ok((file, magic == MAGIC, length))
    });
    let (file, length) = match opened {
        Ok((file, true, length)) => (file, length),
        Ok(_) => return (StatusCode::NOT_FOUND, Json(refused("it is no bag"))).into_response(),
        Err(error) => {
            let reason = format!("{path} cannot be read from here: {error}");
            return (StatusCode::NOT_FOUND, Json(refused(reason))).into_response();
        }
    };
    let name: String = std::path::Path::new(path)
        .file_name()
        .map(|it| it.to_string_lossy())
        .unwrap_or_default()
        .chars()
        .filter(|it| it.is_ascii_alphanumeric() || "._-".contains(*it))
        .collect();
    let disposition = format!("attachment; filename=\"{name}\"");
    let headers = [
        (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
        (header::CONTENT_DISPOSITION, disposition),
    ];
    (headers, Body::from_stream(parts(file, length))).into_response()
}

/// A file's first `length` bytes, a part at a time.
fn parts(
    file: std::fs::File,
    length: u64,
) -> impl Stream<Item = std::io::Result<axum::body::Bytes>> {
    const PART: u64 = 1 << 16;
    futures::stream::unfold((file, 0), move |(file, at)| async move {
        use std::os::unix::fs::FileExt as _;
        let mut part = vec![0; usize::try_from(PART.min(length - at)).unwrap_or(0)];
        if part.is_empty() {
            return None;
        }
        let read = file.read_at(&mut part, at);
        let outcome = read.map(|count| {
            part.truncate(count);
            axum::body::Bytes::from(part)
        });
        // A file that has become shorter ends there.
        let end = match &outcome {
            Ok(part) if !part.is_empty() => at + part.len() as u64,
            _ => length,
        };
        Some((outcome, (file, end)))
    })
}
