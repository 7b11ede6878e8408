//! The page and its socket on 127.0.0.1.

use super::audience::{Hall, json};
use super::guard::{Names, Token};
use super::socket;
use anyhow::{Context, Result};
use axum::Router;
use axum::body::Body;
use axum::extract::{Path, Request, State, WebSocketUpgrade};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::serve::ListenerExt;
use render::live::{Desk, Menu};
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::mpsc;
use std::time::Duration;
use tokio::sync::watch;

/// Largest message of a page.
const MOST_BYTES: usize = 4096;
/// How long open pages may take to be told that the view ends.
const PARTING: Duration = Duration::from_millis(500);

/// The files of the page: name, type, text.
const FILES: [(&str, &str, &str); 4] = [
    ("", "text/html; charset=utf-8", include_str!("page/view.html")),
    ("view.css", "text/css; charset=utf-8", include_str!("page/view.css")),
    ("view.js", "text/javascript; charset=utf-8", include_str!("page/view.js")),
    ("move.js", "text/javascript; charset=utf-8", include_str!("page/move.js")),
];

/// What requests are answered with.
#[derive(Clone)]
pub(super) struct Shared {
    token: Token,
    names: Names,
    pub menu: Arc<Menu>,
    pub desk: Arc<Desk>,
    pub hall: Hall,
    /// Number of the socket that was opened last: the others are closed.
    pub newest: Arc<watch::Sender<u64>>,
    /// Becomes true at the end.
    pub ended: watch::Receiver<bool>,
}

/// A server on a thread of its own.
pub(super) struct Server {
    address: String,
    end: watch::Sender<bool>,
    done: mpsc::Receiver<()>,
}

impl Server {
    /// Serves a page to whoever knows the token.
    ///
    /// # Errors
    /// A system that has no more sockets or threads.
    pub fn start(listener: TcpListener, token: Token, menu: Menu, desk: Arc<Desk>, hall: Hall) -> Result<Self> {
        const FAILED: &str = "the page cannot be served";
        listener.set_nonblocking(true).context(FAILED)?;
        let port = listener.local_addr().context(FAILED)?.port();
        let address = format!("http://127.0.0.1:{port}/{}/", token.text());
        let (end, ended) = watch::channel(false);
        let shared = Shared {
            token,
            names: Names::new(port),
            menu: Arc::new(menu),
            desk,
            hall,
            newest: Arc::new(watch::channel(0).0),
            ended: ended.clone(),
        };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().build().context(FAILED)?;
        let listener = {
            let _inside = runtime.enter();
            // Else a frame waits until the page has acknowledged the status before it.
            tokio::net::TcpListener::from_std(listener).context(FAILED)?.tap_io(|stream| drop(stream.set_nodelay(true)))
        };
        let (tell, done) = mpsc::channel();
        let open = Arc::clone(&shared.newest);
        std::thread::Builder::new()
            .name("page".into())
            .spawn(move || {
                let mut ended = ended;
                let over = async move { drop(ended.wait_for(|ended| *ended).await) };
                // It fails where the system has no more sockets: then no page is served any more.
                let served =
                    runtime.block_on(axum::serve(listener, router(shared)).with_graceful_shutdown(over).into_future());
                if let Err(error) = served {
                    eprintln!("render: the page is not served any more: {error}");
                }
                // Sockets are served no longer than this runs: their farewells would be lost.
                runtime.block_on(open.closed());
                let _ = tell.send(());
            })
            .context(FAILED)?;
        Ok(Self { address, end, done })
    }

    /// Where the page is.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Parts with open pages.
    pub fn stop(self) {
        self.end.send_replace(true);
        // A page that does not listen is left.
        let _ = self.done.recv_timeout(PARTING);
    }
}

fn router(shared: Shared) -> Router {
    Router::new()
        .route("/{token}/", get(|| file("")))
        .route("/{token}/socket", get(open))
        .route("/{token}/{file}", get(|Path((_, name)): Path<(String, String)>| async move { file(&name).await }))
        .fallback(|| async { refused(StatusCode::NOT_FOUND, "there is nothing here") })
        .layer(from_fn_with_state(shared.clone(), guarded))
        .with_state(shared)
}

/// Lets through what is for this page and knows the token; adds what keeps browsers from doing more with it.
async fn guarded(State(shared): State<Shared>, request: Request, next: Next) -> Response {
    let token = request.uri().path().split('/').nth(1).unwrap_or_default();
    let mut response = if !shared.names.is_host(request.headers()) {
        refused(StatusCode::MISDIRECTED_REQUEST, "this page is at 127.0.0.1 only")
    } else if !shared.token.is(token) {
        refused(StatusCode::FORBIDDEN, "the address is not whole: open the one that render view has printed")
    } else {
        next.run(request).await
    };
    let policy = format!(
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self' {}; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
        shared.names.sockets()
    );
    let headers = response.headers_mut();
    if let Ok(policy) = HeaderValue::from_str(&policy) {
        headers.insert(header::CONTENT_SECURITY_POLICY, policy);
    }
    for (name, value) in [
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

/// One of the files.
async fn file(name: &str) -> Response {
    match FILES.iter().find(|(known, ..)| *known == name) {
        Some((_, kind, text)) => {
            ([(header::CONTENT_TYPE, HeaderValue::from_static(kind))], Body::from(*text)).into_response()
        }
        None => refused(StatusCode::NOT_FOUND, "there is nothing here"),
    }
}

/// The socket of the page.
async fn open(State(shared): State<Shared>, headers: HeaderMap, upgrade: WebSocketUpgrade) -> Response {
    if !shared.names.is_origin(&headers) {
        return refused(StatusCode::FORBIDDEN, "only the page itself may open its socket");
    }
    let limited = upgrade.max_message_size(MOST_BYTES).max_frame_size(MOST_BYTES);
    limited.on_upgrade(move |socket| socket::talk(socket, shared))
}

fn refused(status: StatusCode, why: &'static str) -> Response {
    (status, format!("{why}\n")).into_response()
}

impl Shared {
    /// The menu, as the page is sent it.
    pub fn menu(&self) -> String {
        json(&super::audience::Tell { tell: "menu", status: &*self.menu })
    }
}
