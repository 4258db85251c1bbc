//! Who may use the server: names in `Host`, sites in `Origin`, and the token.

use std::net::IpAddr;

use hyper::header::{HeaderMap, HeaderName, AUTHORIZATION, HOST, ORIGIN, SEC_WEBSOCKET_PROTOCOL};
use hyper::StatusCode;

use crate::token::Token;

/// Protocol of the WebSocket that the server selects; the page offers `token.TOKEN` beside it.
pub(crate) const PROTOCOL: &str = "rcs";
const TOKEN_PROTOCOL: &str = "token.";
const TOKEN_SCHEME: &str = "Bearer ";

/// The rules of access.
#[derive(Clone, Debug)]
pub struct Access {
    token: Token,
    names: Vec<String>,
}

/// A refused request: status and reason.
pub(crate) type Refused = (StatusCode, String);

impl Access {
    /// Rules with a token, for a server that is reached by an IP address, as `localhost`, or by one of these names.
    pub fn new(token: Token, names: impl IntoIterator<Item = String>) -> Self {
        Self { token, names: names.into_iter().map(|name| name.to_ascii_lowercase()).collect() }
    }

    /// The token, for the operator's URL.
    pub fn token(&self) -> &Token {
        &self.token
    }

    /// Checks the name by which the server was reached: another one may lead here by DNS rebinding.
    pub(crate) fn check_host(&self, headers: &HeaderMap) -> Result<(), Refused> {
        let Some(host) = only(headers, HOST) else {
            return Err((StatusCode::BAD_REQUEST, "the request needs one header Host".to_owned()));
        };
        if self.is_known(host) {
            return Ok(());
        }
        let why = format!("Host {host}: this server is not known by that name; add it to ~web_hosts");
        Err((StatusCode::FORBIDDEN, why))
    }

    fn is_known(&self, host: &str) -> bool {
        let name = match host.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
            Some((address, port)) => return is_port(port) && address.parse::<std::net::Ipv6Addr>().is_ok(),
            None => match host.split_once(':') {
                Some((name, port)) if port.bytes().all(|digit| digit.is_ascii_digit()) => name,
                Some(_) => return false,
                None => host,
            },
        };
        let name = name.to_ascii_lowercase();
        name == "localhost" || self.names.contains(&name) || name.parse::<IpAddr>().is_ok()
    }

    /// Checks the site whose page sends the request: only this server's own. Programs that are no browsers send none.
    pub(crate) fn check_origin(&self, headers: &HeaderMap) -> Result<(), Refused> {
        if !headers.contains_key(ORIGIN) {
            return Ok(());
        }
        let origin = only(headers, ORIGIN).unwrap_or_default();
        let host = only(headers, HOST).unwrap_or_default();
        let site = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
        if site.is_some_and(|site| site.eq_ignore_ascii_case(host)) {
            return Ok(());
        }
        Err((StatusCode::FORBIDDEN, format!("Origin {origin}: only the page of http://{host} may do this")))
    }

    /// Checks the token of a request.
    pub(crate) fn check_bearer(&self, headers: &HeaderMap) -> Result<(), Refused> {
        self.check_token(only(headers, AUTHORIZATION).and_then(|value| value.strip_prefix(TOKEN_SCHEME)))
    }

    /// Checks the protocols that a WebSocket offers, with the token among them.
    pub(crate) fn check_protocols(&self, headers: &HeaderMap) -> Result<(), Refused> {
        let lists = headers.get_all(SEC_WEBSOCKET_PROTOCOL).iter().filter_map(|value| value.to_str().ok());
        let offered: Vec<&str> = lists.flat_map(|list| list.split(',')).map(str::trim).collect();
        self.check_token(offered.iter().find_map(|protocol| protocol.strip_prefix(TOKEN_PROTOCOL)))?;
        if offered.contains(&PROTOCOL) {
            return Ok(());
        }
        Err((StatusCode::BAD_REQUEST, format!("the WebSocket's protocols must have '{PROTOCOL}' among them")))
    }

    fn check_token(&self, given: Option<&str>) -> Result<(), Refused> {
        if given.is_some_and(|given| self.token.is(given)) {
            return Ok(());
        }
        let why = "the token is missing or wrong; open the address that the node prints when it starts";
        Err((StatusCode::UNAUTHORIZED, why.to_owned()))
    }
}

fn is_port(text: &str) -> bool {
    text.is_empty() || text.strip_prefix(':').is_some_and(|port| port.bytes().all(|digit| digit.is_ascii_digit()))
}

/// The value of a header that stands there once.
fn only(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next().filter(|_| values.next().is_none())?;
    value.to_str().ok()
}

#[cfg(test)]
mod tests {
    use hyper::header::HeaderValue;

    use super::*;

    fn access() -> Access {
        let folder = tempfile::tempdir().unwrap();
        Access::new(Token::load_or_create(&folder.path().join("token")).unwrap(), ["Robot.local".to_owned()])
    }

    fn headers(list: &[(HeaderName, &str)]) -> HeaderMap {
        list.iter().map(|(name, value)| (name.clone(), HeaderValue::from_str(value).unwrap())).collect()
    }

    #[test]
    fn addresses_localhost_and_the_given_names_are_known() {
        let access = access();
        for known in
            ["127.0.0.1:8080", "10.0.0.7", "[::1]:80", "[fe80::1]", "localhost:1", "ROBOT.local", "robot.local:9"]
        {
            assert!(access.is_known(known), "{known}");
        }
        let unknown = [
            "",
            "evil.example",
            "robot.local.evil.example",
            "localhost:x",
            "[::1]x",
            "[x]",
            "127.0.0.1.nip.io",
            "::1:8",
        ];
        for unknown in unknown {
            assert!(!access.is_known(unknown), "{unknown}");
        }
    }

    #[test]
    fn only_pages_of_the_same_host_may_ask() {
        let access = access();
        let check = |origin| access.check_origin(&headers(&[(HOST, "robot.local:8080"), (ORIGIN, origin)])).is_ok();
        assert!(check("http://robot.local:8080") && check("https://Robot.local:8080"));
        for foreign in ["http://robot.local", "http://evil.example", "null", "", "robot.local:8080"] {
            assert!(!check(foreign), "{foreign}");
        }
        assert!(access.check_origin(&headers(&[(HOST, "robot.local:8080")])).is_ok());
    }

    #[test]
    fn a_token_may_be_a_bearers_or_a_protocol() {
        let access = access();
        let token = access.token().text().to_owned();
        let bearer = |text: &str| access.check_bearer(&headers(&[(AUTHORIZATION, text)])).is_ok();
        assert!(bearer(&format!("Bearer {token}")));
        assert!(!bearer(&token) && !bearer("Bearer ") && !bearer(&format!("Bearer {token}0")));
        let status = |text: &str| {
            access
                .check_protocols(&headers(&[(SEC_WEBSOCKET_PROTOCOL, text)]))
                .map_or_else(|(status, _)| status.as_u16(), |()| 101)
        };
        assert_eq!(status(&format!("rcs, token.{token}")), 101);
        assert_eq!([status(&format!("token.{token}")), status("rcs"), status("rcs, token.")], [400, 401, 401]);
    }
}
