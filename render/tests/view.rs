//! `render view` as a browser meets it, without one: who may see the page, what it may ask for, and what is left at the end.

mod support;

use assert_cmd::cargo::CommandCargoExt;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use support::Folder;
use tungstenite::{ClientRequestBuilder, Message, WebSocket};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
/// No answer takes longer, however busy the machine is.
const PATIENCE: Duration = Duration::from_secs(120);

/// A view of the glossy box, small and coarse.
struct View {
    folder: Folder,
    child: Child,
    /// `127.0.0.1:PORT`.
    host: String,
    token: String,
}

type Socket = WebSocket<TcpStream>;

impl View {
    fn open(more: &str) -> Self {
        let folder = Folder::with("", &[]);
        let scene = format!("{ROOT}/tests/scenes/cornell-glossy.xml");
        let args = format!("view {scene} --width 24 --tau 0.3 --spp 2 --tables {ROOT}/tables --denoise off {more}");
        let mut command = Command::cargo_bin("render").unwrap();
        command.current_dir(folder.path("")).args(args.split_whitespace());
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut address = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
        let rest = address.trim().strip_prefix("http://").unwrap_or_else(|| panic!("an address: {address:?}"));
        let (host, token) = rest.trim_end_matches('/').split_once('/').unwrap();
        Self { folder, host: host.into(), token: token.into(), child }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Status and all of the answer to a request.
    fn ask(&self, method: &str, path: &str, host: &str) -> (u16, String) {
        let mut stream = self.connect();
        write!(stream, "{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        (answer.split(' ').nth(1).unwrap().parse().unwrap(), answer)
    }

    fn try_socket(&self, token: &str, headers: &[(&str, &str)]) -> Result<Socket, String> {
        let uri = format!("ws://{}/{token}/socket", self.host).parse().unwrap();
        let request = headers.iter().fold(ClientRequestBuilder::new(uri), |r, (n, v)| r.with_header(*n, *v));
        let opened = tungstenite::client(request, self.connect());
        opened.map(|(socket, _)| socket).map_err(|e| e.to_string())
    }

    /// The socket of the page, and its menu.
    fn socket(&self) -> (Socket, Value) {
        let origin = format!("http://{}", self.host);
        let mut socket = self.try_socket(&self.token, &[("Origin", &origin)]).unwrap();
        let menu = told(&mut socket, "menu");
        (socket, menu)
    }

    /// What ends it as Ctrl-C does: exit code and what was said. Jobs in the background of a script ignore Ctrl-C itself.
    #[cfg(unix)]
    fn end(mut self) -> (Option<i32>, String, Folder) {
        let kill = Command::new("kill").args(["-TERM", &self.child.id().to_string()]).status().unwrap();
        assert!(kill.success());
        let mut said = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        let code = self.child.wait().unwrap().code();
        let folder = std::mem::replace(&mut self.folder, Folder::with("", &[]));
        (code, said, folder)
    }
}

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn send(socket: &mut Socket, order: &Value) {
    socket.send(Message::text(order.to_string())).unwrap();
}

/// The next message of a kind.
fn told(socket: &mut Socket, kind: &str) -> Value {
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            let value: Value = serde_json::from_str(&text).unwrap();
            if value["tell"] == kind {
                return value;
            }
        }
    }
}

/// The next picture that stays: its status, and its bytes.
fn settled(socket: &mut Socket) -> (Value, Vec<u8>) {
    loop {
        let status = told(socket, "status");
        if status["stage"] != "settled" {
            continue;
        }
        match socket.read().unwrap() {
            Message::Binary(picture) => return (status, picture.to_vec()),
            other => panic!("a picture follows its status: {other:?}"),
        }
    }
}

/// The next picture that stays and is another one.
fn settled_unlike(socket: &mut Socket, before: &[u8]) -> Vec<u8> {
    loop {
        let (_, picture) = settled(socket);
        if picture != before {
            return picture;
        }
    }
}

/// Token, host and origin: without one of them nothing is to be had, and no path leads to a file.
#[test]
fn the_page_is_for_whoever_knows_its_address() {
    let view = View::open("");
    let (host, token) = (view.host.as_str(), view.token.as_str());
    let (status, page) = view.ask("GET", &format!("/{token}/"), host);
    assert_eq!(status, 200);
    for header in ["content-security-policy: default-src 'none'", "no-referrer", "nosniff", "no-store", "text/html"] {
        assert!(page.contains(header), "{header}: {page}");
    }
    let port = host.split_once(':').unwrap().1;
    assert_eq!(view.ask("GET", &format!("/{token}/view.js"), &format!("localhost:{port}")).0, 200);
    assert_eq!(view.ask("GET", &format!("/{token}/view.css"), host).0, 200);
    let wrong = format!("{}{}", &token[..token.len() - 1], if token.ends_with('0') { '1' } else { '0' });
    for (path, code) in [
        ("/".into(), 403),
        (format!("/{wrong}/"), 403),
        (format!("/{wrong}/view.js"), 403),
        (format!("/{}/", &token[1..]), 403),
        (format!("/{token}0/"), 403),
        (format!("/{token}/../Cargo.toml"), 404),
        (format!("/{token}/%2e%2e%2fCargo.toml"), 404),
        (format!("/{token}/etc/passwd"), 404),
    ] {
        let (status, answer) = view.ask("GET", &path, host);
        assert_eq!(status, code, "{path}: {answer}");
    }
    assert_eq!(view.ask("POST", &format!("/{token}/"), host).0, 405);
    for host in ["example.com", "127.0.0.1", "evil.test:80"] {
        assert_eq!(view.ask("GET", &format!("/{token}/"), host).0, 421, "{host}");
    }
    let own = format!("http://{host}");
    for (token, headers) in [
        (wrong.as_str(), &[("Origin", own.as_str())][..]),
        (token, &[("Origin", "http://example.com")]),
        (token, &[("Origin", "null")]),
        (token, &[]),
    ] {
        let refused = view.try_socket(token, headers).err().unwrap_or_else(|| panic!("{token} {headers:?} came in"));
        assert!(refused.contains("403"), "{refused}");
    }
    view.socket();
}

/// Whatever is sent, the view goes on: nonsense is an answer, too much ends the socket, and a page may come again.
#[test]
fn nonsense_is_answered_and_harms_nothing() {
    let view = View::open("");
    let (mut socket, menu) = view.socket();
    assert_eq!(menu["size"], json!([24, 24]));
    assert!(menu["methods"].as_array().unwrap().iter().any(|method| method[0] == "path"));
    settled(&mut socket);
    for bad in [
        "",
        "{",
        "[]",
        "null",
        r#"{"do": "fly"}"#,
        r#"{"do": "turn", "yaw": 1e999, "pitch": 0}"#,
        r#"{"do": "turn", "yaw": "NaN", "pitch": 0}"#,
        r#"{"do": "walk", "forward": 1e9, "right": 0, "up": 0}"#,
        r#"{"do": "method", "name": "../../etc/passwd"}"#,
        r#"{"do": "record", "on": true, "file": "/tmp/x"}"#,
        r#"{"do": "tau", "tau": -1}"#,
        r#"{"do": "denoise", "on": true}"#,
    ] {
        socket.send(Message::text(bad)).unwrap();
        let error = told(&mut socket, "error");
        assert!(error["message"].as_str().is_some_and(|m| !m.is_empty() && !m.contains('\n')), "{bad}: {error}");
    }
    socket.send(Message::binary(vec![0u8; 100])).unwrap();
    told(&mut socket, "error");
    // One page at a time: the newest.
    let (mut second, _) = view.socket();
    let close = loop {
        match socket.read().unwrap() {
            Message::Close(frame) => break frame.unwrap(),
            _ => continue,
        }
    };
    assert!(close.reason.contains("another page"), "{close}");
    // Larger than any order.
    let _ = second.send(Message::text("x".repeat(1 << 20)));
    while second.read().is_ok() {}
    let (mut third, _) = view.socket();
    settled(&mut third);
}

/// Orders change the picture, which comes to rest again; views and walks that are saved are paths for `render walk`; Ctrl-C keeps what was
/// gathered.
#[cfg(unix)]
#[test]
fn a_walk_is_seen_recorded_and_kept() {
    let view = View::open("--cache box.cache --record walk.csv");
    let (mut socket, _) = view.socket();
    let (status, first) = settled(&mut socket);
    assert_eq!((&status["spp"], &status["method"]), (&json!([2, 2]), &json!("auto")));
    assert!(status["records"].as_u64().unwrap() > 0);
    send(&mut socket, &json!({"do": "record", "on": true}));
    send(&mut socket, &json!({"do": "turn", "yaw": 0.2, "pitch": 0.1}));
    let turned = settled_unlike(&mut socket, &first);
    // Walking sends frames without end, until it is told to stop.
    send(&mut socket, &json!({"do": "walk", "forward": 0.5, "right": 0, "up": 0}));
    for _ in 0..5 {
        while told(&mut socket, "status")["stage"] != "moving" {}
    }
    send(&mut socket, &json!({"do": "walk", "forward": 0, "right": 0, "up": 0}));
    let walked = settled_unlike(&mut socket, &turned);
    send(&mut socket, &json!({"do": "record", "on": false}));
    let walk = told(&mut socket, "walk");
    send(&mut socket, &json!({"do": "mark"}));
    let mark = told(&mut socket, "view");
    send(&mut socket, &json!({"do": "exposure", "stops": 2}));
    let brighter = settled_unlike(&mut socket, &walked);
    send(&mut socket, &json!({"do": "method", "name": "path"}));
    while settled(&mut socket).0["method"] != "path" {}
    send(&mut socket, &json!({"do": "home"}));
    settled_unlike(&mut socket, &brighter);

    let (code, said, folder) = view.end();
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("records kept") && !said.contains("panicked"), "{said}");
    let recorded = std::fs::read_to_string(folder.path("walk.csv")).unwrap();
    assert_eq!(Some(recorded.as_str()), walk["csv"].as_str());
    std::fs::write(folder.path("view.csv"), mark["csv"].as_str().unwrap()).unwrap();
    let scene = format!("{ROOT}/tests/scenes/cornell-glossy.xml --width 16 --tau 0.3 --spp 1 --tables {ROOT}/tables");
    folder.ok(&format!("walk {scene} --method path --path view.csv -o view/####.png")
        .replace("--tau 0.3 ", "")
        .replace(&format!("--tables {ROOT}/tables"), ""));
    folder.ok(&format!("walk {scene} --method auto --path walk.csv --frames 1 --denoise off -o walk/####.png"));
    folder.ok("cache info box.cache");
    folder.ok(&format!("image {scene} --method auto --cache box.cache -o image.png"));
    let left: Vec<_> = std::fs::read_dir(folder.path("")).unwrap().flatten().map(|e| e.file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().contains(".lock")), "{left:?}");
}

/// A port that is taken, options that do not go together, files that cannot be: one line.
#[test]
fn mistakes_are_one_line() {
    let folder = Folder::with("<scene/>", &[]);
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    for (args, mention) in [
        (format!("scene.xml --port {port}"), format!("--port {port} is taken")),
        ("scene.xml --port 0".into(), "--port".into()),
        ("scene.xml --method path --tau 0.1".into(), "--tau".into()),
        ("scene.xml --method path --cache a.cache".into(), "--cache".into()),
        ("scene.xml --tau 0.9".into(), "--tau".into()),
        ("scene.xml --record walk.txt".into(), "walk.txt".into()),
        ("scene.xml --record no/walk.csv".into(), "walk.csv".into()),
        ("scene.xml --cache scene.xml".into(), "scene.xml".into()),
        ("missing.xml".into(), "missing.xml".into()),
    ] {
        let said = folder.bad(&format!("view {args}"), &mention);
        assert_eq!(
            said.trim().lines().filter(|line| line.starts_with("render:") || line.starts_with("error")).count(),
            1,
            "{args}: {said}"
        );
    }
    std::fs::write(folder.path("bad.cache"), "x").unwrap();
    let scene = format!("{ROOT}/tests/scenes/cornell-glossy.xml --tables {ROOT}/tables");
    folder.bad(&format!("view {scene} --cache bad.cache"), "bad.cache");
}
