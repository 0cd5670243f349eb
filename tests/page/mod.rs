//! The page of `planesman watch`, as a client that is no browser asks for it.

// Each test program uses its own part.
#![allow(dead_code, clippy::unwrap_used)]

use std::io::{self, Read as _, Write as _};
use std::net::TcpStream;

use crate::stage::{PATIENCE, Process, Stage, eventually};

/// Where a page is, and what it takes to see it.
#[derive(Clone, Debug)]
pub(crate) struct Page {
    /// `127.0.0.1:PORT`.
    pub(crate) host: String,
    pub(crate) token: String,
}

/// `planesman watch`, and its page.
pub(crate) fn watch(stage: &Stage) -> (Process, Page) {
    let program = stage.start_as(
        &["watch", "--no-open"],
        &[(planesman::nodes::LAUNCHED, "1")],
    );
    let page = Page::of(&program);
    (program, page)
}

impl Page {
    /// The page whose address the program has printed.
    pub(crate) fn of(program: &Process) -> Self {
        eventually("the page's address", || {
            let printed = program.stdout();
            let lines = printed.lines();
            let mut pages = lines.filter_map(|line| line.strip_prefix("http://"));
            let (host, token) = pages.next()?.split_once("/?token=")?;
            Some(Self {
                host: host.to_owned(),
                token: token.to_owned(),
            })
        })
    }

    /// The address that was printed.
    pub(crate) fn address(&self) -> String {
        format!("http://{}/?token={}", self.host, self.token)
    }

    /// The header with the cookie that the page's browser sends.
    pub(crate) fn cookie(&self) -> String {
        let (_, port) = self.host.rsplit_once(':').unwrap();
        format!("Cookie: planesman_watch_{port}={}", self.token)
    }

    /// The headers of a request by the page itself.
    pub(crate) fn own(&self) -> [String; 3] {
        let origin = format!("Origin: http://{}", self.host);
        [format!("Host: {}", self.host), self.cookie(), origin]
    }

    /// A connection on which this has been sent.
    pub(crate) fn send(&self, text: &str) -> TcpStream {
        self.try_send(text).unwrap()
    }

    fn try_send(&self, text: &str) -> io::Result<TcpStream> {
        let mut stream = TcpStream::connect(&self.host)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.write_all(text.as_bytes())?;
        Ok(stream)
    }

    /// The answer to a request with these headers, and this body if it is a POST.
    pub(crate) fn answer(&self, request: &str, headers: &[&str], body: &str) -> String {
        self.try_answer(request, headers, body).unwrap()
    }

    /// Like [`answer`](Self::answer), where others may have taken the connection's place.
    pub(crate) fn try_answer(
        &self,
        request: &str,
        headers: &[&str],
        body: &str,
    ) -> io::Result<String> {
        let headers: String = headers.iter().map(|it| format!("{it}\r\n")).collect();
        let length = body.len();
        let mut stream = self.try_send(&format!(
            "{request} HTTP/1.1\r\n{headers}Content-Length: {length}\r\nConnection: close\r\n\r\n{body}"
        ))?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer)?;
        Ok(String::from_utf8_lossy(&answer).into_owned())
    }

    /// The answer to what the page itself asks for.
    pub(crate) fn get(&self, target: &str) -> String {
        let own = self.own();
        self.answer(
            &format!("GET {target}"),
            &own.each_ref().map(String::as_str),
            "",
        )
    }

    /// The answer to what the page itself has done.
    pub(crate) fn post(&self, body: &str) -> String {
        let [host, cookie, origin] = self.own();
        let json = "Content-Type: application/json";
        self.answer("POST /do", &[&host, &cookie, &origin, json], body)
    }

    /// The page's stream of these channels, as it comes.
    pub(crate) fn stream(&self, channels: &[&str]) -> TcpStream {
        let query: Vec<String> = channels.iter().map(|it| format!("channel={it}")).collect();
        let own = self.own().join("\r\n");
        self.send(&format!(
            "GET /events?{} HTTP/1.1\r\n{own}\r\n\r\n",
            query.join("&")
        ))
    }
}
