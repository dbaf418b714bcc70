//! Access to the server: a request needs the token, an own page as origin, and an own name as host.

use std::net::IpAddr;

use axum::http::header::{HOST, ORIGIN};
use axum::http::{HeaderMap, StatusCode, Uri};

/// Length of a random token (bytes).
const TOKEN_BYTES: usize = 16;
/// Minimum length of a token that the user chose.
const MIN_LENGTH: usize = 16;

/// Checks of requests.
#[derive(Clone, Debug)]
pub struct Guard {
    token: String,
}

impl Guard {
    /// Returns a guard with a random token.
    ///
    /// # Errors
    ///
    /// If the system gives no random numbers.
    pub fn random() -> Result<Guard, getrandom::Error> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes)?;
        Ok(Guard { token: bytes.iter().map(|byte| format!("{byte:02x}")).collect() })
    }

    /// Returns a guard with a token that the user chose, so that a page outlives the program.
    ///
    /// # Errors
    ///
    /// If the token is too short, or has characters other than letters and digits.
    pub fn chosen(token: &str) -> Result<Guard, String> {
        if token.len() < MIN_LENGTH || !token.chars().all(|c| c.is_ascii_alphanumeric()) {
            return Err(format!("give at least {MIN_LENGTH} letters and digits"));
        }
        Ok(Guard { token: token.into() })
    }

    /// The token.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// Returns the refusal of a request, if any. A foreign page may have had the name in `Host` resolved to this machine,
    /// so it must be an own name. Requests of other pages are known by `Origin`.
    pub fn refuses(&self, uri: &Uri, headers: &HeaderMap) -> Option<(StatusCode, &'static str)> {
        let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
        let Some(host) = text(HOST).filter(|host| is_own(host)) else {
            return Some((StatusCode::MISDIRECTED_REQUEST, "ask for localhost, or for an address"));
        };
        if headers.contains_key(ORIGIN) && text(ORIGIN) != Some(&format!("http://{host}")) {
            return Some((StatusCode::FORBIDDEN, "this is not for other pages"));
        }
        let given = uri.query().into_iter().flat_map(|query| query.split('&'));
        let given = given.filter_map(|pair| pair.strip_prefix("token=")).next_back().unwrap_or_default();
        if !is_equal(given, &self.token) {
            return Some((
                StatusCode::FORBIDDEN,
                "the address lacks its token; take the one that the program printed",
            ));
        }
        None
    }
}

/// Whether a host, with or without port, is localhost or a numeric address.
fn is_own(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.chars().all(|c| c.is_ascii_digit()) => name,
        _ => host,
    };
    let bare = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
    name == "localhost" || bare.parse::<IpAddr>().is_ok()
}

/// Whether two texts are equal; the time taken does not reveal where they differ.
fn is_equal(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |different, (a, b)| different | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(address: &str, host: Option<&str>, origin: Option<&str>) -> Option<u16> {
        let guard = Guard::chosen("0123456789abcdef").unwrap();
        let mut headers = HeaderMap::new();
        host.map(|host| headers.insert(HOST, host.parse().unwrap()));
        origin.map(|origin| headers.insert(ORIGIN, origin.parse().unwrap()));
        guard.refuses(&address.parse().unwrap(), &headers).map(|(status, _)| status.as_u16())
    }

    #[test]
    fn a_token_a_host_and_an_origin_of_its_own_are_needed() {
        let right = "/ws?token=0123456789abcdef";
        for host in ["127.0.0.1:8317", "localhost:9000", "localhost", "[::1]:8317", "192.168.1.7:80"] {
            assert_eq!(refused(right, Some(host), None), None, "{host}");
            assert_eq!(refused(right, Some(host), Some(&format!("http://{host}"))), None, "{host}");
        }
        for host in
            ["evil.example", "evil.example:8317", "localhost.evil.example", "127.0.0.1.evil.example:1", ""]
        {
            assert_eq!(refused(right, Some(host), None), Some(421), "{host}");
        }
        assert_eq!(refused(right, None, None), Some(421));
        for origin in ["http://evil.example", "null", "http://127.0.0.1:8318", "https://127.0.0.1:8317"] {
            assert_eq!(refused(right, Some("127.0.0.1:8317"), Some(origin)), Some(403), "{origin}");
        }
        for wrong in
            ["/ws", "/ws?token=", "/ws?token=0123456789abcdeX", "/ws?token=0123456789abcdef0", "/?other=1"]
        {
            assert_eq!(refused(wrong, Some("127.0.0.1:8317"), None), Some(403), "{wrong}");
        }
    }

    #[test]
    fn tokens_cannot_be_guessed() {
        let [one, other] = [Guard::random().unwrap(), Guard::random().unwrap()];
        assert_ne!(one.token(), other.token());
        assert_eq!(one.token().len(), 32);
        assert!(Guard::chosen("short").is_err() && Guard::chosen("0123456789abcde&f").is_err());
    }
}
