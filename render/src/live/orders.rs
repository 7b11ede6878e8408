//! Orders are followed between two frames.

use super::desk::{Answer, Orders};
use super::recorder::Recorder;
use super::session::Session;
use super::status::Status;
use crate::image::view::Display;
use crate::inspect::overlay::Marks;
use crate::walk::write_rows;
use std::time::{Duration, Instant};

/// No step of a walk is longer, however long the last frame took.
const LONGEST_STEP: Duration = Duration::from_millis(250);
/// Time between rows of a recorded walk while nothing happens.
const RECORDING: Duration = Duration::from_millis(90);

/// What orders have changed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Change {
    /// All of it is to end.
    pub leave: bool,
    /// Method or τ.
    pub engine: bool,
    /// What the camera sees.
    pub view: bool,
    /// How it is shown.
    pub look: bool,
}

impl Change {
    /// Whether another picture is asked for.
    pub fn stops(self) -> bool {
        self.leave || self.engine || self.view
    }
}

impl Session<'_> {
    /// Follows the orders that have come; waits for them so long.
    pub(super) fn heed(&mut self, wait: Duration) -> Change {
        let wait = if self.recorder.is_some() { wait.min(RECORDING) } else { wait };
        let orders = self.desk.take(wait);
        let now = Instant::now();
        let walks = orders.walk != [0.0; 3];
        let passed = if self.looked.1 { (now - self.looked.0).min(LONGEST_STEP).as_secs_f64() } else { 0.0 };
        self.looked = (now, walks);
        let mut change = Change { leave: orders.leave, view: orders.worthless || walks, ..Change::default() };
        self.move_by(&orders, passed);
        self.choose(&orders, &mut change);
        self.look(&orders, &mut change);
        self.note(&orders, now, &mut change);
        change
    }

    fn move_by(&mut self, orders: &Orders, passed: f64) {
        if orders.home {
            self.navigator.home();
        }
        if let Some(factor) = orders.hurry {
            self.navigator.hurry(factor);
        }
        let [yaw, pitch] = orders.turn;
        if orders.turn != [0.0; 2] {
            self.navigator.turn(yaw, pitch);
        }
        if orders.step != [0.0; 3] {
            self.navigator.step(orders.step);
        }
        let way = orders.walk.map(|x| x * passed);
        if way != [0.0; 3] {
            self.navigator.go(way);
        }
    }

    fn choose(&mut self, orders: &Orders, change: &mut Change) {
        let named = |name: &String| self.options.engines.iter().position(|engine| engine.name == *name);
        if let Some(engine) = orders.method.as_ref().and_then(named).filter(|engine| *engine != self.engine) {
            (self.engine, change.engine) = (engine, true);
            self.status.method.clone_from(&self.options.engines[engine].name);
        }
        let interpolation = &mut self.status.interpolation;
        if let Some(other) = orders.interpolation.filter(|other| other != interpolation) {
            (*interpolation, change.engine) = (other, true);
        }
        if let Some(tau) = orders.tau.filter(|tau| *tau != self.status.tau) {
            (self.status.tau, change.engine) = (tau, true);
            // Records of any other τ are not asked for again soon, but for those that a file may keep.
            let first = (self.options.engine, self.options.tolerance.to_bits());
            self.shelf.retain(|key, _| *key == first || key.1 == tau.to_bits());
        }
    }

    fn look(&mut self, orders: &Orders, change: &mut Change) {
        let Status { stops, view, denoise, marks, .. } = &mut self.status;
        let before = (*stops, *view, *denoise, *marks);
        *stops = orders.stops.unwrap_or(*stops);
        *view = orders.view.unwrap_or(*view);
        *denoise = orders.denoise.unwrap_or(*denoise) && self.options.denoiser.is_some();
        *marks = orders.marks.map_or(*marks, |Marks { dots, zones }| [dots, zones]);
        if before != (*stops, *view, *denoise, *marks) {
            change.look = true;
            self.display = Display::new((*view).into(), *stops);
        }
    }

    /// Answers what is asked of the camera, and notes its way.
    fn note(&mut self, orders: &Orders, now: Instant, change: &mut Change) {
        let (axis, aspect) = self.options.fov;
        let row = self.navigator.row(axis, aspect);
        if orders.mark {
            self.audience.tell(Answer::View { csv: write_rows([(1, &row)]) });
        }
        match orders.record {
            Some(true) if self.recorder.is_none() => {
                (self.recorder, change.look) = (Some(Recorder::new(now, row)), true);
            }
            Some(false) => {
                change.look |= self.recorder.is_some();
                self.end_record();
            }
            _ => {}
        }
        if self.recorder.as_mut().is_some_and(|recorder| !recorder.note(now, row)) {
            self.audience.tell(Answer::Error { message: "the recorded walk is as long as it may be".into() });
            self.end_record();
        }
        self.status.recording = self.recorder.as_ref().map(Recorder::rows);
    }

    pub(super) fn end_record(&mut self) {
        if let Some(recorder) = self.recorder.take() {
            self.audience.tell(Answer::Walk { csv: recorder.csv(), rows: recorder.rows() });
        }
    }
}
