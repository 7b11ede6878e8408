//! Where orders wait until they are followed. They are put together as they come, so that however many come, they take no more room.

use super::command::{Command, Shown};
use crate::inspect::overlay::Marks;
use crate::integrator::cached::{Halt, Interpolation};
use serde::Serialize;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// What a page is told besides frames.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "tell", rename_all = "kebab-case")]
pub enum Answer {
    /// The camera, as a path of one row.
    View {
        /// CSV with its header.
        csv: String,
    },
    /// A walk that was recorded.
    Walk {
        /// CSV with its header.
        csv: String,
        /// Its rows.
        rows: usize,
    },
    /// What went wrong.
    Error {
        /// One line.
        message: String,
    },
}

/// Orders that have come since the last time they were taken.
#[derive(Debug, Default)]
pub(super) struct Orders {
    pub turn: [f64; 2],
    pub step: [f64; 3],
    /// Kept until it changes.
    pub walk: [f64; 3],
    pub hurry: Option<f64>,
    pub home: bool,
    pub method: Option<String>,
    pub interpolation: Option<Interpolation>,
    pub tau: Option<f32>,
    pub stops: Option<f32>,
    pub view: Option<Shown>,
    pub denoise: Option<bool>,
    pub marks: Option<Marks>,
    /// Whether the camera is asked for.
    pub mark: bool,
    pub record: Option<bool>,
    /// Whether all of it is to end.
    pub leave: bool,
    /// Whether they make the picture in work worthless.
    pub worthless: bool,
    any: bool,
}

/// Orders on their way from a page to a session; any thread may write to it.
#[derive(Debug, Default)]
pub struct Desk {
    orders: Mutex<Orders>,
    came: Condvar,
    /// Set by orders that make the picture in work worthless.
    pub(super) halt: Halt,
}

impl Desk {
    /// Leaves an order, which [`super::Menu::check`] has found good.
    pub fn tell(&self, command: Command) {
        self.change(|orders| match command {
            Command::Turn { yaw, pitch } => {
                orders.turn[0] += yaw;
                orders.turn[1] += pitch;
                true
            }
            Command::Step { forward, right, up } => {
                for (sum, way) in orders.step.iter_mut().zip([forward, right, up]) {
                    *sum += way;
                }
                true
            }
            Command::Walk { forward, right, up } => {
                orders.walk = [forward, right, up];
                orders.walk != [0.0; 3]
            }
            Command::Hurry { factor } => {
                orders.hurry = Some((orders.hurry.unwrap_or(1.0) * factor).clamp(1e-3, 1e3));
                false
            }
            Command::Home {} => {
                (orders.home, orders.turn, orders.step) = (true, [0.0; 2], [0.0; 3]);
                true
            }
            Command::Method { name } => {
                orders.method = Some(name);
                true
            }
            Command::Interpolation { name } => {
                orders.interpolation = Some(name);
                true
            }
            Command::Tau { tau } => {
                orders.tau = Some(tau);
                true
            }
            Command::Exposure { stops } => {
                orders.stops = Some(stops);
                false
            }
            Command::View { name } => {
                orders.view = Some(name);
                false
            }
            Command::Denoise { on } => {
                orders.denoise = Some(on);
                false
            }
            Command::Marks { dots, zones } => {
                orders.marks = Some(Marks { dots, zones });
                false
            }
            Command::Mark {} => {
                orders.mark = true;
                false
            }
            Command::Record { on } => {
                orders.record = Some(on);
                false
            }
        });
    }

    /// Stops the walk of a page that is gone.
    pub fn stand(&self) {
        self.tell(Command::Walk { forward: 0.0, right: 0.0, up: 0.0 });
    }

    /// Ends the session.
    pub fn leave(&self) {
        self.change(|orders| {
            orders.leave = true;
            true
        });
    }

    /// `change` tells whether the picture in work is of no use any more.
    fn change(&self, change: impl FnOnce(&mut Orders) -> bool) {
        let mut orders = self.orders.lock().unwrap_or_else(PoisonError::into_inner);
        if change(&mut orders) {
            orders.worthless = true;
            self.halt.set(true);
        }
        orders.any = true;
        self.came.notify_all();
    }

    /// What has come; waits for it so long.
    pub(super) fn take(&self, wait: Duration) -> Orders {
        let orders = self.orders.lock().unwrap_or_else(PoisonError::into_inner);
        let idle = |orders: &mut Orders| !orders.any && orders.walk == [0.0; 3];
        let (mut orders, _) = self.came.wait_timeout_while(orders, wait, idle).unwrap_or_else(PoisonError::into_inner);
        let left = Orders { walk: orders.walk, leave: orders.leave, ..Orders::default() };
        self.halt.set(orders.leave);
        core::mem::replace(&mut orders, left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_put_together() {
        let desk = Desk::default();
        for _ in 0..1000 {
            desk.tell(Command::Turn { yaw: 0.001, pitch: -0.002 });
        }
        desk.tell(Command::Walk { forward: 1.0, right: 0.0, up: 0.0 });
        desk.tell(Command::Tau { tau: 0.1 });
        desk.tell(Command::Tau { tau: 0.2 });
        assert!(desk.halt.is_set());
        let orders = desk.take(Duration::ZERO);
        assert!((orders.turn[0] - 1.0).abs() < 1e-9 && (orders.turn[1] + 2.0).abs() < 1e-9);
        assert_eq!((orders.walk, orders.tau), ([1.0, 0.0, 0.0], Some(0.2)));
        assert!(!desk.halt.is_set());
        let orders = desk.take(Duration::ZERO);
        assert_eq!((orders.walk, orders.turn, orders.tau), ([1.0, 0.0, 0.0], [0.0; 2], None));
        // What changes the look of a picture does not stop it.
        desk.tell(Command::Exposure { stops: 1.0 });
        desk.stand();
        assert!(!desk.halt.is_set());
        assert_eq!(desk.take(Duration::ZERO).walk, [0.0; 3]);
        desk.leave();
        assert!(desk.take(Duration::ZERO).leave && desk.halt.is_set());
        assert!(desk.take(Duration::ZERO).leave, "there is no way back");
    }
}
