//! What a page and the session say to each other.

use super::audience::{Newest, json};
use super::server::Shared;
use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, close_code};
use render::live::{Answer, Command};
use tokio::sync::broadcast::error::RecvError;

/// Why the server is the one who closes.
const REPLACED: &str = "the view was opened in another page";
const ENDED: &str = "the view has ended";
/// Bytes of a reason at most, by the protocol.
const WHY: usize = 120;

/// Sends frames and answers, and follows orders, until the page is gone, another one is opened, or the view ends.
pub(super) async fn talk(mut socket: WebSocket, shared: Shared) {
    let mut number = 0;
    shared.newest.send_modify(|newest| {
        *newest += 1;
        number = *newest;
    });
    let (mut newest, mut ended) = (shared.newest.subscribe(), shared.ended.clone());
    let why = tokio::select! {
        why = converse(&mut socket, &shared) => why,
        _ = newest.wait_for(|newest| *newest != number) => Some(REPLACED),
        _ = ended.wait_for(|ended| *ended) => Some(ENDED),
    };
    if why != Some(REPLACED) {
        shared.desk.stand();
    }
    if let Some(why) = why {
        let reason = Utf8Bytes::from_static(&why[..why.len().min(WHY)]);
        // A page that is gone needs no farewell.
        let _ = socket.send(Message::Close(Some(CloseFrame { code: close_code::NORMAL, reason }))).await;
    }
}

/// Until the page is gone, or nobody draws any more: then the page is told.
async fn converse(socket: &mut WebSocket, shared: &Shared) -> Option<&'static str> {
    let (mut frames, mut answers) = (shared.hall.frames.clone(), shared.hall.answers.subscribe());
    frames.mark_changed();
    let mut shown = 0;
    if socket.send(Message::Text(shared.menu().into())).await.is_err() {
        return None;
    }
    loop {
        let sent = tokio::select! {
            message = socket.recv() => match message {
                Some(Ok(message)) => match follow(shared, &message) {
                    Ok(()) => Ok(()),
                    Err(message) => send(socket, json(&Answer::Error { message })).await,
                },
                // Gone, or no web socket any more: too much at once, or not text.
                Some(Err(_)) | None => return None,
            },
            changed = frames.changed() => {
                if changed.is_err() {
                    return Some(ENDED);
                }
                let newest = frames.borrow_and_update().clone();
                show(socket, &newest, &mut shown).await
            }
            answer = answers.recv() => match answer {
                Ok(answer) => send(socket, answer).await,
                Err(RecvError::Lagged(_)) => Ok(()),
                Err(RecvError::Closed) => return Some(ENDED),
            },
        };
        if sent.is_err() {
            return None;
        }
    }
}

async fn send(socket: &mut WebSocket, text: String) -> Result<(), axum::Error> {
    socket.send(Message::Text(text.into())).await
}

/// Sends a frame: the status, then the picture where it is new.
async fn show(socket: &mut WebSocket, newest: &Newest, shown: &mut u64) -> Result<(), axum::Error> {
    if !newest.status.is_empty() {
        send(socket, newest.status.clone()).await?;
    }
    if newest.number != *shown {
        *shown = newest.number;
        socket.send(Message::Binary(newest.picture.clone())).await?;
    }
    Ok(())
}

/// Leaves an order at the desk, if it is one.
fn follow(shared: &Shared, message: &Message) -> Result<(), String> {
    match message {
        Message::Text(text) => {
            let command: Command = serde_json::from_str(text).map_err(|e| format!("not an order: {e}"))?;
            shared.menu.check(&command)?;
            shared.desk.tell(command);
            Ok(())
        }
        Message::Binary(_) => Err("not an order: bytes".into()),
        Message::Ping(_) | Message::Pong(_) | Message::Close(_) => Ok(()),
    }
}
