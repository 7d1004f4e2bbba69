//! Which requests are accepted. The page drives only a simulation, but no other page shall drive it.
//!
//! - The host name must be this machine's: a foreign name that was made to point here (DNS rebinding) is refused.
//! - A browser states from which page a request comes; only this server's page may open the WebSocket.
//! - Beyond this machine it also takes the token that was printed.

use std::net::{IpAddr, SocketAddr};

use axum::http::header::{HOST, ORIGIN};
use axum::http::{HeaderMap, Uri};

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// The host name is not this server's.
    Host,
    /// The request comes from another page.
    Origin,
    /// No token, or a wrong one.
    Token,
}

impl Refusal {
    pub fn words(self) -> &'static str {
        match self {
            Self::Host => "open this page by its IP address or as localhost",
            Self::Origin => "another page may not control this one",
            Self::Token => "open the address that was printed, with its token",
        }
    }
}

fn text(headers: &HeaderMap, name: axum::http::HeaderName) -> Option<&str> {
    headers.get(name).and_then(|value| value.to_str().ok())
}

/// True if `host` (name or number, and port) is the server at `address`.
fn is_own(host: &str, address: SocketAddr) -> bool {
    // A browser leaves out the usual port.
    let split = if host.ends_with(']') { None } else { host.rsplit_once(':') };
    let (name, port) = split.unwrap_or((host, "80"));
    if port.parse() != Ok(address.port()) {
        return false;
    }
    let name = name.trim_start_matches('[').trim_end_matches(']');
    let number = name.parse::<IpAddr>().ok();
    let local = name.eq_ignore_ascii_case("localhost") || number.is_some_and(|ip| ip.is_loopback());
    // A number cannot be made to point elsewhere; a name can.
    local || (number.is_some() && !address.ip().is_loopback())
}

/// Equal, in a time that does not depend on where they differ.
fn same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |all, (x, y)| all | (x ^ y)) == 0
}

/// Looks at a request for the page.
pub(crate) fn check_host(headers: &HeaderMap, address: SocketAddr) -> Result<(), Refusal> {
    let host = text(headers, HOST).ok_or(Refusal::Host)?;
    if is_own(host, address) { Ok(()) } else { Err(Refusal::Host) }
}

/// Looks at a request for the WebSocket.
pub(crate) fn check(
    headers: &HeaderMap,
    uri: &Uri,
    address: SocketAddr,
    token: Option<&str>,
) -> Result<(), Refusal> {
    check_host(headers, address)?;
    let own = text(headers, HOST).map(|host| format!("http://{host}"));
    // A program that is no browser sends no origin. One that cannot be read is a foreign one.
    if headers.contains_key(ORIGIN) && text(headers, ORIGIN) != own.as_deref() {
        return Err(Refusal::Origin);
    }
    let Some(token) = token else { return Ok(()) };
    let mut given = uri.query().unwrap_or("").split('&').filter_map(|part| part.strip_prefix("token="));
    if given.any(|given| same(given, token)) { Ok(()) } else { Err(Refusal::Token) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn headers(host: &'static str, origin: Option<&'static str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(HOST, HeaderValue::from_static(host));
        if let Some(origin) = origin {
            headers.insert(ORIGIN, HeaderValue::from_static(origin));
        }
        headers
    }

    fn home() -> SocketAddr {
        SocketAddr::from(([127, 0, 0, 1], 4747))
    }

    fn at_home(host: &'static str, origin: Option<&'static str>) -> Result<(), Refusal> {
        check(&headers(host, origin), &Uri::from_static("/ws"), home(), None)
    }

    #[test]
    fn the_own_page_comes_in_by_any_name_of_this_machine() {
        for host in ["127.0.0.1:4747", "localhost:4747", "LOCALHOST:4747", "[::1]:4747"] {
            assert_eq!(at_home(host, None), Ok(()), "{host}");
        }
        assert_eq!(at_home("localhost:4747", Some("http://localhost:4747")), Ok(()));
    }

    #[test]
    fn the_usual_port_is_left_out() {
        let usual = SocketAddr::from(([127, 0, 0, 1], 80));
        let ask = |host, origin| check(&headers(host, origin), &Uri::from_static("/ws"), usual, None);
        assert_eq!(ask("localhost", Some("http://localhost")), Ok(()));
        assert_eq!(ask("[::1]", None), Ok(()));
        assert_eq!(ask("evil.example", None), Err(Refusal::Host));
        assert_eq!(ask("localhost:4747", None), Err(Refusal::Host));
    }

    #[test]
    fn a_foreign_name_another_port_or_another_machine_is_no_host() {
        for host in
            ["evil.example:4747", "127.0.0.1", "127.0.0.1:80", "192.168.1.2:4747", "localhost.evil:4747", ""]
        {
            assert_eq!(at_home(host, None), Err(Refusal::Host), "{host}");
        }
        let none = check(&HeaderMap::new(), &Uri::from_static("/ws"), home(), None);
        assert_eq!(none, Err(Refusal::Host));
    }

    #[test]
    fn a_page_of_another_origin_is_refused() {
        for origin in [
            "http://evil.example",
            "http://localhost:8080",
            "https://localhost:4747",
            "null",
            "http://127.0.0.1:4747",
        ] {
            assert_eq!(at_home("localhost:4747", Some(origin)), Err(Refusal::Origin), "{origin}");
        }
    }

    #[test]
    fn beyond_this_machine_it_takes_the_token_and_an_address_in_numbers() {
        let address = SocketAddr::from(([0, 0, 0, 0], 4747));
        let ask = |host: &'static str, uri: &'static str| {
            check(&headers(host, None), &Uri::from_static(uri), address, Some("c0ffee"))
        };
        assert_eq!(ask("192.168.1.2:4747", "/ws?token=c0ffee"), Ok(()));
        assert_eq!(ask("192.168.1.2:4747", "/ws?v=1&token=c0ffee"), Ok(()));
        for uri in ["/ws", "/ws?token=", "/ws?token=c0ffef", "/ws?token=c0ffee0", "/ws?atoken=c0ffee"] {
            assert_eq!(ask("192.168.1.2:4747", uri), Err(Refusal::Token), "{uri}");
        }
        assert_eq!(ask("evil.example:4747", "/ws?token=c0ffee"), Err(Refusal::Host));
    }
}
