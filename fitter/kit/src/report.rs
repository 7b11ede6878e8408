//! An error as one line.

/// An error and its causes in one line: what an error says already, or has said, is not said again.
pub fn one_line(error: &anyhow::Error) -> String {
    let mut parts: Vec<String> = Vec::new();
    for cause in error.chain().map(ToString::to_string) {
        match parts.last_mut() {
            Some(last) if last.ends_with(&cause) => {}
            // A place that the cause names itself.
            Some(last) if cause.strip_prefix(last.as_str()).is_some_and(|rest| rest.starts_with(':')) => *last = cause,
            _ => parts.push(cause),
        }
    }
    parts.join(": ").replace(char::is_control, " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::{Context, anyhow};

    #[test]
    fn nothing_is_said_twice() {
        let io = || std::io::Error::other("no such file");
        #[derive(Debug, thiserror::Error)]
        #[error("a.exr: {source}")]
        struct Named {
            source: std::io::Error,
        }
        let said = |e: anyhow::Error| one_line(&e);
        assert_eq!(said(Named { source: io() }.into()), "a.exr: no such file");
        assert_eq!(said(anyhow::Error::from(Named { source: io() }).context("a.exr")), "a.exr: no such file");
        assert_eq!(said(Err::<(), _>(io()).context("b").unwrap_err()), "b: no such file");
        assert_eq!(said(anyhow!("two\nlines\t")), "two lines ");
    }
}
