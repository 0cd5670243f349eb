//! Who may ask: the page itself, from an address that the user gave.
//!
//! A page of elsewhere that is open in the same browser can send requests to this server. It cannot read the answers, and
//! requests that change something are refused by their `Origin`. A name that such a page resolves to this
//! machine's address (DNS rebinding) is refused by `Host`. Beyond loopback everybody on the network could ask: there a token is needed.

use std::net::IpAddr;

use axum::http::{HeaderMap, StatusCode, header};

/// What a request must show.
#[derive(Clone, Debug)]
pub(crate) struct Guard {
    /// Needed beyond loopback.
    pub(crate) token: Option<String>,
    local: bool,
}

/// The cookie that holds the token.
pub(crate) const COOKIE: &str = "planesman_watch";

/// Why a request is not answered.
pub(crate) type Refusal = (StatusCode, &'static str);

impl Guard {
    /// The guard of a server at that address, with a new token where one is needed.
    pub(crate) fn of(address: IpAddr) -> Result<Self, getrandom::Error> {
        let local = address.is_loopback();
        let token = match local {
            true => None,
            false => Some(new_token()?),
        };
        Ok(Self { token, local })
    }

    /// Whether a request with these headers is answered, apart from the token.
    pub(crate) fn admit(&self, headers: &HeaderMap, changes: bool) -> Result<(), Refusal> {
        let text = |name| headers.get(name).and_then(|it| it.to_str().ok());
        let host = text(header::HOST).unwrap_or_default();
        if !self.is_own(host) {
            return Err((
                StatusCode::MISDIRECTED_REQUEST,
                "ask by the address that planesman watch has printed\n",
            ));
        }
        let origin = text(header::ORIGIN);
        let own = format!("http://{host}");
        if origin.is_some_and(|origin| origin != own) || (changes && origin.is_none()) {
            return Err((
                StatusCode::FORBIDDEN,
                "only the page of planesman watch itself may ask\n",
            ));
        }
        Ok(())
    }

    /// Whether the host is an address, of this machine if only this machine is served: a name can be anybody's.
    fn is_own(&self, host: &str) -> bool {
        let name = match host.rsplit_once(':') {
            Some((name, port)) if port.bytes().all(|it| it.is_ascii_digit()) => name,
            _ => host,
        };
        let name = name.trim_start_matches('[').trim_end_matches(']');
        match name.parse::<IpAddr>() {
            Ok(address) => !self.local || address.is_loopback(),
            Err(_) => name == "localhost",
        }
    }

    /// Whether the token in the address or in the cookie is the right one.
    pub(crate) fn knows(&self, headers: &HeaderMap, query: Option<&str>) -> bool {
        let Some(token) = &self.token else {
            return true;
        };
        let in_query = query_token(query);
        let cookies = headers.get_all(header::COOKIE).iter();
        let in_cookie = cookies
            .filter_map(|it| it.to_str().ok())
            .flat_map(|it| it.split(';'))
            .filter_map(|it| it.trim().split_once('='))
            .filter(|(name, _)| *name == COOKIE)
            .map(|(_, value)| value);
        in_query
            .into_iter()
            .chain(in_cookie)
            .any(|given| same(given, token))
    }
}

/// The token in an address.
pub(crate) fn query_token(query: Option<&str>) -> Option<&str> {
    let mut parts = query?.split('&');
    parts.find_map(|part| part.strip_prefix("token="))
}

/// 128 random bits.
fn new_token() -> Result<String, getrandom::Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.map(|byte| format!("{byte:02x}")).concat())
}

/// Equal, in a time that does not tell how far.
fn same(given: &str, token: &str) -> bool {
    let differing = given.bytes().zip(token.bytes());
    given.len() == token.len() && differing.fold(0, |all, (a, b)| all | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(list: &[(&str, &str)]) -> HeaderMap {
        let pairs = list.iter().map(|(name, value)| {
            let name: header::HeaderName = name.parse().expect("a header's name");
            (name, value.parse().expect("a header's value"))
        });
        pairs.collect()
    }

    #[test]
    fn on_loopback_only_its_own_page_may_ask() {
        let guard = Guard::of("127.0.0.1".parse().expect("an address")).expect("random bits");
        assert!(guard.token.is_none() && guard.knows(&HeaderMap::new(), None));
        for (given, changes, admitted) in [
            (&[("host", "127.0.0.1:8080")][..], false, true),
            (&[("host", "localhost:8080")], false, true),
            (&[("host", "[::1]:8080")], false, true),
            (&[("host", "evil.example:8080")], false, false),
            (&[("host", "127.0.0.1.evil.example")], false, false),
            (&[("host", "192.168.1.5:8080")], false, false),
            (&[], false, false),
            (&[("host", "127.0.0.1:1")], true, false),
            (
                &[("host", "127.0.0.1:1"), ("origin", "http://127.0.0.1:1")],
                true,
                true,
            ),
            (
                &[("host", "127.0.0.1:1"), ("origin", "http://127.0.0.1:2")],
                true,
                false,
            ),
            (
                &[("host", "127.0.0.1:1"), ("origin", "https://evil.example")],
                false,
                false,
            ),
            (&[("host", "127.0.0.1:1"), ("origin", "null")], true, false),
        ] {
            let outcome = guard.admit(&headers(given), changes);
            assert_eq!(outcome.is_ok(), admitted, "{given:?}");
        }
    }

    #[test]
    fn beyond_loopback_the_token_is_needed() {
        let guard = Guard::of("0.0.0.0".parse().expect("an address")).expect("random bits");
        let token = guard.token.clone().expect("a token");
        assert_eq!(token.len(), 32);
        let other = Guard::of("0.0.0.0".parse().expect("an address")).expect("random bits");
        assert_ne!(Some(&token), other.token.as_ref());
        let cookie = format!("a=b; {COOKIE}={token}");
        assert!(guard.knows(&headers(&[("cookie", &cookie)]), None));
        assert!(guard.knows(&HeaderMap::new(), Some(&format!("x=1&token={token}"))));
        for wrong in ["", &token[1..], &format!("{token}0"), &"0".repeat(32)] {
            let query = format!("token={wrong}");
            assert!(!guard.knows(&HeaderMap::new(), Some(&query)), "{wrong}");
        }
        assert!(!guard.knows(&HeaderMap::new(), None));
        let asked = headers(&[("host", "192.168.1.5:8080")]);
        assert!(guard.admit(&asked, false).is_ok());
        assert!(
            guard
                .admit(&headers(&[("host", "evil.example")]), false)
                .is_err()
        );
    }
}
