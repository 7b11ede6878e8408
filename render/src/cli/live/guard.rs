//! Who may see the page: whoever knows its address, from a browser on this machine.
//!
//! The address has a random token, without which nothing is answered. A page of a stranger in the same browser may send requests here,
//! and may have its own name resolve to 127.0.0.1: `Host` and `Origin` tell that they are not of this page.

use anyhow::{Result, anyhow};
use axum::http::{HeaderMap, HeaderName, header};
use subtle::ConstantTimeEq;

/// Random bytes of a token.
const BYTES: usize = 16;

/// What an address must hold.
#[derive(Clone)]
pub(super) struct Token(String);

impl Token {
    /// A new one.
    ///
    /// # Errors
    /// A system without random numbers.
    pub fn new() -> Result<Self> {
        let mut bytes = [0u8; BYTES];
        getrandom::fill(&mut bytes).map_err(|e| anyhow!("no random numbers: {e}"))?;
        Ok(Self(bytes.iter().map(|b| format!("{b:02x}")).collect()))
    }

    /// As it stands in the address.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Whether it is this one; takes as long however much of it is right.
    pub fn is(&self, text: &str) -> bool {
        self.0.as_bytes().ct_eq(text.as_bytes()).into()
    }
}

/// The names under which the page is known.
#[derive(Clone)]
pub(super) struct Names([String; 2]);

impl Names {
    /// On a port of this machine.
    pub fn new(port: u16) -> Self {
        Self(["127.0.0.1", "localhost"].map(|host| format!("{host}:{port}")))
    }

    /// Whether a request is for this page.
    pub fn is_host(&self, headers: &HeaderMap) -> bool {
        only(headers, &header::HOST).is_some_and(|host| self.0.iter().any(|name| host.eq_ignore_ascii_case(name)))
    }

    /// Whether a request comes from this page.
    pub fn is_origin(&self, headers: &HeaderMap) -> bool {
        let origin = only(headers, &header::ORIGIN).and_then(|origin| origin.strip_prefix("http://"));
        origin.is_some_and(|origin| self.0.iter().any(|name| origin.eq_ignore_ascii_case(name)))
    }

    /// Where the page may connect to.
    pub fn sockets(&self) -> String {
        self.0.iter().map(|name| format!("ws://{name}")).collect::<Vec<_>>().join(" ")
    }
}

/// The value of a header that is there once.
fn only<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_told_apart() {
        let [a, b] = [Token::new().unwrap(), Token::new().unwrap()];
        assert!(a.is(a.text()) && !a.is(b.text()) && a.text().len() == 2 * BYTES);
        assert!(!a.is("") && !a.is(&a.text()[1..]) && !a.is(&format!("{}0", a.text())));
    }

    #[test]
    fn only_this_page_is_known() {
        let names = Names::new(8080);
        let headers = |name: HeaderName, values: &[&str]| {
            let mut headers = HeaderMap::new();
            for value in values {
                headers.append(name.clone(), value.parse().unwrap());
            }
            headers
        };
        let host = |values: &[&str]| names.is_host(&headers(header::HOST, values));
        assert!(host(&["127.0.0.1:8080"]) && host(&["LocalHost:8080"]));
        for bad in [&["127.0.0.1"][..], &["127.0.0.1:80"], &["example.com:8080"], &[], &["localhost:8080", "x"]] {
            assert!(!host(bad), "{bad:?}");
        }
        let origin = |values: &[&str]| names.is_origin(&headers(header::ORIGIN, values));
        assert!(origin(&["http://localhost:8080"]));
        for bad in [&["null"][..], &["https://localhost:8080"], &["http://example.com"], &[], &["http://localhost:80"]]
        {
            assert!(!origin(bad), "{bad:?}");
        }
    }
}
