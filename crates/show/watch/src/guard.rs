//! Authentication: requests are answered only from the page itself, at the printed address, with the token.
//!
//! Anyone who can connect could command the vehicle: every user of this machine, and with another address than loopback everybody on the
//! network. So every request needs the token of the printed address; the first visit stores it in a cookie. Foreign pages in the same browser can
//! also send requests, with the cookie if they come from another port of the same address. Such requests are refused because of the headers
//! `Sec-Fetch-Site`, which scripts cannot set, and `Origin`. A foreign name that resolves to this machine's address (DNS rebinding) is refused by
//! `Host`.

use std::net::IpAddr;

use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri, header};

/// The checks of a request.
pub(crate) struct Guard {
    pub(crate) token: String,
    local: bool,
}

/// HTTP status and text of a refused request.
pub(crate) type Refusal = (StatusCode, &'static str);

impl Guard {
    /// The guard of a server at this address, with a new token.
    pub(crate) fn of(address: IpAddr) -> Result<Self, getrandom::Error> {
        Ok(Self {
            token: new_token()?,
            local: address.is_loopback(),
        })
    }

    /// Checks a request; for a first visit returns the cookie to set.
    pub(crate) fn admit(
        &self,
        method: &Method,
        uri: &Uri,
        headers: &HeaderMap,
    ) -> Result<Option<HeaderValue>, Refusal> {
        let one = |name| headers.get(name).and_then(|it| it.to_str().ok());
        let host = one(header::HOST).unwrap_or_default();
        let several = headers.get_all(header::HOST).iter().nth(1).is_some();
        if several || !self.is_own(host) {
            return Err((
                StatusCode::MISDIRECTED_REQUEST,
                "Open the address that planesman watch printed\n",
            ));
        }
        let is_known = query_token(uri.query()).is_some_and(|given| same(given, &self.token));
        let is_get = matches!(*method, Method::GET | Method::HEAD);
        let says_nothing_but = |name: &str, allowed: &[&str]| {
            let mut given = headers.get_all(name).iter();
            given.all(|it| allowed.iter().any(|one| it.as_bytes() == one.as_bytes()))
        };
        // The printed address may be opened from anywhere: whoever has the token could visit by himself.
        let is_visit = is_known
            && is_get
            && uri.path() == "/"
            && says_nothing_but("sec-fetch-mode", &["navigate"])
            && says_nothing_but("sec-fetch-dest", &["document"]);
        let origin = format!("http://{host}");
        let is_of_the_page = says_nothing_but("sec-fetch-site", &["same-origin", "none"])
            && says_nothing_but("origin", &[&origin])
            && (is_get || headers.contains_key(header::ORIGIN));
        if !(is_visit || is_of_the_page) {
            return Err((
                StatusCode::FORBIDDEN,
                "Requests from other pages are refused: open the address that planesman watch printed\n",
            ));
        }
        let name = cookie_name(host);
        if !(is_known || cookies(headers, &name).any(|given| same(given, &self.token))) {
            return Err((
                StatusCode::UNAUTHORIZED,
                "This page needs the token: open the address that planesman watch printed\n",
            ));
        }
        let cookie = format!("{name}={}; HttpOnly; SameSite=Strict; Path=/", self.token);
        Ok(HeaderValue::try_from(cookie).ok().filter(|_| is_visit))
    }

    /// Whether the host is an IP address (a loopback address if only this machine is served), because a name could belong to anyone.
    fn is_own(&self, host: &str) -> bool {
        let (name, _) = name_and_port(host);
        let name = name.trim_start_matches('[').trim_end_matches(']');
        match name.parse::<IpAddr>() {
            Ok(address) => !self.local || address.is_loopback(),
            Err(_) => name == "localhost",
        }
    }
}

fn name_and_port(host: &str) -> (&str, &str) {
    match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|it| it.is_ascii_digit()) => (name, port),
        _ => (host, "80"),
    }
}

/// Name of the token's cookie. A browser shares cookies among all ports of an address, so each port has its own name.
fn cookie_name(host: &str) -> String {
    format!("planesman_watch_{}", name_and_port(host).1)
}

/// The values of all cookies with this name.
fn cookies<'a>(headers: &'a HeaderMap, name: &'a str) -> impl Iterator<Item = &'a str> {
    let all = headers.get_all(header::COOKIE).iter();
    all.filter_map(|it| it.to_str().ok())
        .flat_map(|it| it.split(';'))
        .filter_map(|it| it.trim().split_once('='))
        .filter_map(move |(given, value)| (given == name).then_some(value))
}

/// The token in the query of an address.
fn query_token(query: Option<&str>) -> Option<&str> {
    let mut parts = query?.split('&');
    parts.find_map(|part| part.strip_prefix("token="))
}

/// A new token of 128 random bits.
fn new_token() -> Result<String, getrandom::Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.map(|byte| format!("{byte:02x}")).concat())
}

/// Compares two texts in constant time.
fn same(given: &str, token: &str) -> bool {
    let differing = given.bytes().zip(token.bytes());
    given.len() == token.len() && differing.fold(0, |all, (a, b)| all | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The status of a request with these headers to a guard whose cookie it has; 200 for an answer.
    fn status(guard: &Guard, request: &str, given: &[(&str, &str)]) -> u16 {
        let (method, target) = request.split_once(' ').expect("METHOD TARGET");
        let (method, uri) = (method.parse().expect("one"), target.parse().expect("one"));
        let pairs = given.iter().map(|(name, value)| {
            let name: header::HeaderName = name.parse().expect("a header's name");
            (name, value.parse().expect("a header's value"))
        });
        let mut headers = HeaderMap::new();
        for (name, value) in pairs {
            headers.append(name, value);
        }
        match guard.admit(&method, &uri, &headers) {
            Ok(_) => 200,
            Err((status, _)) => status.as_u16(),
        }
    }

    #[test]
    fn what_a_page_of_elsewhere_sends_is_refused_on_every_route_even_with_the_cookie() {
        let guard = Guard::of([127, 0, 0, 1].into()).expect("random bits");
        let cookie = format!("a=b; planesman_watch_8080={}", guard.token);
        let host = ("host", "127.0.0.1:8080");
        let own = ("origin", "http://127.0.0.1:8080");
        let site = |it| ("sec-fetch-site", it);
        for (given, get, post) in [
            (&[host][..], 200, 403),
            (&[host, own], 200, 200),
            (&[host, site("none")], 200, 403),
            (&[host, own, site("same-origin")], 200, 200),
            (&[host, site("same-site")], 403, 403),
            (&[host, site("cross-site")], 403, 403),
            (&[host, own, site("cross-site")], 403, 403),
            (&[host, site("none"), site("cross-site")], 403, 403),
            (&[host, ("origin", "http://127.0.0.1:2")], 403, 403),
            (&[host, ("origin", "https://evil.example")], 403, 403),
            (&[host, ("origin", "null")], 403, 403),
            (&[host, own, ("origin", "http://127.0.0.1:2")], 403, 403),
            (&[("host", "localhost:8080")], 200, 403),
            (&[("host", "[::1]:8080")], 200, 403),
            (&[("host", "evil.example:8080")], 421, 421),
            (&[("host", "127.0.0.1.evil.example")], 421, 421),
            (&[("host", "192.168.1.5:8080")], 421, 421),
            (&[host, ("host", "evil.example")], 421, 421),
            (&[], 421, 421),
        ] {
            let given = [given, &[("cookie", cookie.as_str())]].concat();
            for target in ["/", "/events?channel=a:b", "/bag?node=x", "/main.js"] {
                let answer = status(&guard, &format!("GET {target}"), &given);
                assert_eq!(answer, get, "{target} {given:?}");
            }
            assert_eq!(status(&guard, "POST /do", &given), post, "{given:?}");
        }
    }

    #[test]
    fn nobody_is_answered_without_the_token_of_this_server() {
        for address in ["127.0.0.1", "::1", "0.0.0.0"] {
            let guard = Guard::of(address.parse().expect("an address")).expect("random bits");
            let other = Guard::of(address.parse().expect("an address")).expect("random bits");
            let token = &guard.token;
            assert_eq!(token.len(), 32);
            assert_ne!(*token, other.token);
            let host = ("host", "127.0.0.1:8080");
            let target = format!("GET /charts?x=1&token={token}");
            assert_eq!(status(&guard, &target, &[host]), 200);
            assert_eq!(status(&other, &target, &[host]), 401);
            assert_eq!(status(&guard, "GET /charts", &[host]), 401);
            for wrong in ["", &token[1..], &format!("{token}0"), &"0".repeat(32)] {
                let target = format!("GET /charts?token={wrong}");
                assert_eq!(status(&guard, &target, &[host]), 401, "{wrong}");
            }
            // A cookie is good for the port that it was given for, though a browser sends it to each.
            let cookie = format!(
                "planesman_watch_8080={token}; planesman_watch_9090={}",
                other.token
            );
            for (guard, host, answer) in [
                (&guard, "127.0.0.1:8080", 200),
                (&guard, "127.0.0.1:9090", 401),
                (&other, "127.0.0.1:9090", 200),
            ] {
                let given = [("host", host), ("cookie", cookie.as_str())];
                assert_eq!(status(guard, "GET /charts", &given), answer, "{host}");
            }
        }
    }

    #[test]
    fn the_printed_address_may_be_opened_from_anywhere_and_gives_the_cookie() {
        let guard = Guard::of([127, 0, 0, 1].into()).expect("random bits");
        let page = format!("GET /?token={}", guard.token);
        let navigation = [
            ("host", "127.0.0.1:8080"),
            ("sec-fetch-site", "cross-site"),
            ("sec-fetch-mode", "navigate"),
            ("sec-fetch-dest", "document"),
        ];
        assert_eq!(status(&guard, &page, &navigation), 200);
        assert_eq!(status(&guard, "GET /?token=0", &navigation), 403);
        let framed = [&navigation[..3], &[("sec-fetch-dest", "iframe")]].concat();
        assert_eq!(status(&guard, &page, &framed), 403);
        let fetched = [&navigation[..2], &[("sec-fetch-mode", "no-cors")]].concat();
        assert_eq!(status(&guard, &page, &fetched), 403);
        let headers = [(header::HOST, HeaderValue::from_static("localhost"))];
        let uri = format!("/?token={}", guard.token)
            .parse()
            .expect("a target");
        let cookie = guard.admit(&Method::GET, &uri, &HeaderMap::from_iter(headers));
        let text = format!(
            "planesman_watch_80={}; HttpOnly; SameSite=Strict; Path=/",
            guard.token
        );
        assert_eq!(cookie.expect("admitted").expect("a cookie"), text);
    }
}
