//! HTTP server: the page, its event stream, and its requests.

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener};
use std::pin::pin;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::Body;
use axum::extract::{
    DefaultBodyLimit, Extension, FromRequest as _, Json, RawQuery, Request as HttpRequest, State,
};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::sse::{Event, Sse};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use futures::Stream;
use futures::future::select;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use rustix::net::sockopt;
use serde_json::Value;
use tokio::net::TcpStream;
use tokio::sync::{Semaphore, oneshot};
use tokio::time::{MissedTickBehavior, sleep, timeout};

use crate::Error;
use crate::bag_file::Disks;
use crate::board::{Reader, SharedBoard, locked};
use crate::charts;
use crate::command::{Command, Request, refused};
use crate::guard::Guard;
use crate::units;
use crate::visitors::{Visitor, Visitors};

/// Interval of messages to a page: thirty per second.
const UPDATE_PERIOD: Duration = Duration::from_millis(33);
/// Longest interval between two messages to a page.
const KEEP_ALIVE_PERIOD: Duration = Duration::from_secs(5);
/// Maximum number of simultaneous requests.
const MAX_REQUESTS: usize = 64;
/// Maximum number of channels per page.
const MAX_CHANNELS: usize = 256;
/// Largest head of a request, and largest body, bytes.
const MAX_REQUEST_BYTES: usize = 1 << 16;
/// Timeout for a request's head, including the first or next one of a connection, and for its body.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);
const BODY_TIMEOUT: Duration = Duration::from_secs(10);
/// Time after which a connection that accepts no data is closed, ms.
const UNREAD_TIMEOUT_MS: u32 = 30_000;
/// Size of the send buffer of a page, bytes; newer data need not wait for more than this.
const SEND_BUFFER: usize = 1 << 17;
/// Timeout of the node's answer: longer than the node waits for any other node.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(30);

/// Content policy: only the page's own files are loaded or run, and no other page may embed it.
const POLICY: &str = "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; \
                      form-action 'none'; frame-ancestors 'none'";

/// The page's files: path, type and text.
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
        include_str!("../../show/uplot/uPlot.iife.min.js"),
    ),
    (
        "/uPlot.css",
        CSS,
        include_str!("../../show/uplot/uPlot.min.css"),
    ),
];
const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// Data shared by the handlers.
#[derive(Clone)]
struct Shared {
    board: SharedBoard,
    requests: smol::channel::Sender<Request>,
    guard: Arc<Guard>,
    under_way: Arc<Semaphore>,
    disks: Disks,
}

/// A server that listens, but does not answer yet.
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
    ) -> Result<Self, Error> {
        let listener =
            TcpListener::bind(address).map_err(|reason| Error::Listen(address, reason))?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            address: listener.local_addr()?,
            listener,
            shared: Shared {
                board,
                requests,
                guard: Arc::new(Guard::of(address.ip())?),
                under_way: Arc::new(Semaphore::new(MAX_REQUESTS)),
                disks: Disks::default(),
            },
        })
    }

    /// Address of the page, with the token.
    pub(crate) fn page(&self) -> String {
        format!("http://{}/?token={}", self.address, self.shared.guard.token)
    }

    /// Starts answering, on a separate thread.
    pub(crate) fn start(self) -> Result<(), Error> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .build()?;
        let serve = move || {
            let served: std::io::Result<()> = runtime.block_on(async {
                let listener = tokio::net::TcpListener::from_std(self.listener)?;
                serve(listener, &routes(self.shared)).await;
                Ok(())
            });
            if let Err(error) = served {
                log::error!("the page cannot be served: {error}");
            }
        };
        std::thread::Builder::new()
            .name("page".to_owned())
            .spawn(serve)?;
        Ok(())
    }
}

/// Accepts connections, each in its own task.
async fn serve(listener: tokio::net::TcpListener, router: &Router) {
    let visitors = Visitors::default();
    loop {
        match listener.accept().await {
            Ok((stream, from)) => {
                let (visitor, closed) = visitors.enter(from.ip());
                tokio::spawn(attend(stream, router.clone(), visitor, closed));
                // Its request, which mostly is there already, is read before more take its place.
                tokio::task::yield_now().await;
            }
            Err(error) if error.kind() == ErrorKind::ConnectionAborted => {}
            // Too many files are open.
            Err(_) => sleep(Duration::from_millis(100)).await,
        }
    }
}

/// Answers the requests of a connection until either side closes it.
async fn attend(
    stream: TcpStream,
    router: Router,
    visitor: Visitor,
    closed: oneshot::Receiver<()>,
) {
    // Without them a connection that is not read is held for longer.
    let _ = sockopt::set_tcp_user_timeout(&stream, UNREAD_TIMEOUT_MS);
    let _ = sockopt::set_socket_send_buffer_size(&stream, SEND_BUFFER);
    let (routes, carried) = (TowerToHyperService::new(router), visitor.clone());
    let service = service_fn(move |mut request: hyper::Request<Incoming>| {
        request.extensions_mut().insert(carried.clone());
        routes.call(request)
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .max_buf_size(MAX_REQUEST_BYTES)
        .serve_connection(TokioIo::new(stream), service);
    select(pin!(connection), closed).await;
    visitor.leave();
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
        .layer(DefaultBodyLimit::max(MAX_REQUEST_BYTES))
        .layer(from_fn_with_state(shared.clone(), admit))
        .with_state(shared)
}

/// Answers only admitted requests, and sends the page's content policy.
async fn admit(
    State(shared): State<Shared>,
    Extension(visitor): Extension<Visitor>,
    request: HttpRequest,
    next: Next,
) -> Response {
    let mut response = match shared
        .guard
        .admit(request.method(), request.uri(), request.headers())
    {
        Err(refusal) => refusal.into_response(),
        Ok(cookie) => {
            visitor.is_known();
            let mut response = next.run(request).await;
            if let Some(cookie) = cookie {
                response.headers_mut().insert(header::SET_COOKIE, cookie);
            }
            response
        }
    };
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (
            HeaderName::from_static("cross-origin-resource-policy"),
            "same-origin",
        ),
    ] {
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
    }
    response
}

/// The event stream of a page: everything new in the channels of `?channel=A&channel=B`, in the kept channels, and elsewhere, thirty times a
/// second. A channel's number is its first position in the query.
async fn events(
    State(shared): State<Shared>,
    Extension(visitor): Extension<Visitor>,
    RawQuery(query): RawQuery,
) -> Sse<impl Stream<Item = Result<Event, axum::Error>>> {
    visitor.begins_stream();
    let mut seen = BTreeSet::new();
    let channels = values(query.as_deref(), "channel").enumerate();
    let channels = channels.filter(|(_, name)| seen.insert(name.clone()));
    let reader = Reader::of(channels.take(MAX_CHANNELS));
    let mut timer = tokio::time::interval(UPDATE_PERIOD);
    timer.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let stream = Streamed {
        reader,
        board: shared.board,
        timer,
    };
    Sse::new(futures::stream::unfold(stream, async |mut it| {
        let event = it.next().await;
        Some((event, it))
    }))
}

/// The event stream of one page. Nothing is queued: a message is made only after the last one has been sent.
struct Streamed {
    reader: Reader,
    board: SharedBoard,
    timer: tokio::time::Interval,
}

impl Streamed {
    async fn next(&mut self) -> Result<Event, axum::Error> {
        let since = Instant::now();
        loop {
            if !self.reader.is_behind() {
                self.timer.tick().await;
            }
            let message = self.reader.updates(&locked(&self.board));
            // An empty message says that the connection is there.
            if !message.is_empty() || since.elapsed() > KEEP_ALIVE_PERIOD {
                return Event::default().json_data(message);
            }
        }
    }
}

/// The values of this name in a query.
fn values<'a>(query: Option<&'a str>, name: &'a str) -> impl Iterator<Item = String> + use<'a> {
    form_urlencoded::parse(query.unwrap_or_default().as_bytes())
        .filter(move |(key, _)| key == name)
        .map(|(_, value)| value.into_owned())
}

/// Sends a request to the node and waits for its answer.
async fn ask(shared: &Shared, command: Command) -> Value {
    let (reply, answered) = oneshot::channel();
    let request = Request { command, reply };
    let asking = async {
        shared.requests.send(request).await.ok()?;
        answered.await.ok()
    };
    match timeout(ANSWER_TIMEOUT, asking).await {
        Ok(answer) => answer.unwrap_or_else(|| refused("the node has stopped")),
        Err(_) => refused("the node of planesman watch does not answer"),
    }
}

/// Executes a page's request.
async fn execute(State(shared): State<Shared>, request: HttpRequest) -> Response {
    let Ok(_permit) = shared.under_way.try_acquire() else {
        return busy("too many requests at once");
    };
    match timeout(BODY_TIMEOUT, Json::<Command>::from_request(request, &())).await {
        Ok(Ok(Json(command))) => Json(ask(&shared, command).await).into_response(),
        Ok(Err(rejection)) => {
            (rejection.status(), Json(refused(rejection.body_text()))).into_response()
        }
        Err(_) => {
            let reason = refused("the request did not arrive completely");
            (StatusCode::REQUEST_TIMEOUT, Json(reason)).into_response()
        }
    }
}

fn busy(text: &str) -> Response {
    (StatusCode::SERVICE_UNAVAILABLE, Json(refused(text))).into_response()
}

/// The file that a recorder currently writes, up to the part already written.
async fn bag(State(shared): State<Shared>, RawQuery(query): RawQuery) -> Response {
    let Ok(permit) = shared.under_way.try_acquire() else {
        return busy("too many requests at once");
    };
    let node = values(query.as_deref(), "node").next().unwrap_or_default();
    let told = ask(&shared, Command::Bag { node }).await;
    drop(permit);
    let Some(path) = told["file"].as_str() else {
        return (StatusCode::NOT_FOUND, Json(told)).into_response();
    };
    let (file, length) = match shared.disks.open(path.to_owned()).await {
        Ok(opened) => opened,
        Err(error) => {
            let reason = format!("cannot read {path} on this machine: {error}");
            return match error.kind() {
                ErrorKind::TimedOut => busy(&reason),
                _ => (StatusCode::NOT_FOUND, Json(refused(reason))).into_response(),
            };
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
    let parts = shared.disks.parts(file, length);
    (headers, Body::from_stream(parts)).into_response()
}
