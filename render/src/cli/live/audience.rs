//! From the session to whoever has the page open.

use anyhow::Result;
use axum::body::Bytes;
use kit::output::write;
use render::live::{Answer, Audience, Frame};
use std::path::PathBuf;
use std::sync::Arc;
use tokio::sync::{broadcast, watch};

/// Answers that wait for a page at most.
const WAITING: usize = 16;

/// The newest frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Newest {
    /// Number of its picture; 0 before the first.
    pub number: u64,
    /// As JPEG.
    pub picture: Bytes,
    /// As JSON.
    pub status: String,
}

/// Where pages listen.
#[derive(Clone)]
pub(super) struct Hall {
    pub frames: watch::Receiver<Arc<Newest>>,
    pub answers: broadcast::Sender<String>,
}

/// Sends frames and answers to pages, and recorded walks to a file.
pub(super) struct Page {
    frames: watch::Sender<Arc<Newest>>,
    answers: broadcast::Sender<String>,
    record: Option<PathBuf>,
    /// Whether the last walk is in its file.
    recorded: Result<()>,
}

impl Page {
    /// Without a frame yet. `record` is the file of walks.
    pub fn open(record: Option<PathBuf>) -> (Self, Hall) {
        let (frames, newest) = watch::channel(Arc::default());
        let (answers, _) = broadcast::channel(WAITING);
        let hall = Hall { frames: newest, answers: answers.clone() };
        (Self { frames, answers, record, recorded: Ok(()) }, hall)
    }

    /// Tells whether the last recorded walk was written.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn close(self) -> Result<()> {
        self.recorded
    }

    fn answer(&self, answer: &Answer) {
        // Where no page listens, nobody asked.
        let _ = self.answers.send(json(answer));
    }
}

impl Audience for Page {
    fn show(&mut self, frame: Frame) {
        let status = json(&Tell { tell: "status", status: frame.status });
        let before = Arc::clone(&self.frames.borrow());
        let newest = match frame.jpeg {
            Some(jpeg) => Newest { number: before.number + 1, picture: jpeg.into(), status },
            None => Newest { status, ..(*before).clone() },
        };
        self.frames.send_replace(Arc::new(newest));
    }

    fn tell(&mut self, answer: Answer) {
        if let (Answer::Walk { csv, rows }, Some(path)) = (&answer, &self.record) {
            self.recorded = write(path, csv.as_bytes()).map_err(Into::into);
            match &self.recorded {
                Ok(()) => eprintln!("render: {}: a walk of {rows} rows", path.display()),
                Err(error) => self.answer(&Answer::Error { message: kit::one_line(error) }),
            }
        }
        self.answer(&answer);
    }
}

/// A message of a kind.
#[derive(serde::Serialize)]
pub(super) struct Tell<'a, T> {
    pub tell: &'a str,
    #[serde(flatten)]
    pub status: T,
}

/// As JSON; what is sent is made of numbers and words, and has no key that JSON does not know.
pub(super) fn json(message: &impl serde::Serialize) -> String {
    serde_json::to_string(message).unwrap_or_default()
}
