//! What a page may ask for.

use crate::image::view::View;
use crate::integrator::cached::Interpolation;
use serde::{Deserialize, Serialize};

/// Largest angle of a turn, radian, and way of a step, seconds of walking: what a hand does between two frames is less.
const MOST_ANGLE: f64 = 7.0;
const MOST_WAY: f64 = 60.0;

/// Least and largest τ.
pub const TAUS: [f32; 2] = [0.005, 0.5];
/// Largest exposure either way, stops.
const MOST_STOPS: f32 = 16.0;

/// An order. As JSON: `{"do": "turn", "yaw": 0.1, "pitch": 0}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Command {
    /// Turns to the left and upwards, radian.
    Turn {
        /// To the left.
        yaw: f64,
        /// Upwards.
        pitch: f64,
    },
    /// Goes a way at once, each in seconds of walking.
    Step {
        /// Ahead.
        forward: f64,
        /// To the right.
        right: f64,
        /// Upwards.
        up: f64,
    },
    /// Walks on and on, each from −1 to 1 of the usual speed; zeros stop.
    Walk {
        /// Ahead.
        forward: f64,
        /// To the right.
        right: f64,
        /// Upwards.
        up: f64,
    },
    /// Walks so many times as fast as before.
    Hurry {
        /// The factor, ½ to 2.
        factor: f64,
    },
    /// Goes back to the camera of the scene.
    Home {},
    /// Renders by another method.
    Method {
        /// One of the menu.
        name: String,
    },
    /// Who sums the records of a pixel.
    Interpolation {
        /// Its name.
        name: Interpolation,
    },
    /// Another quality of records.
    Tau {
        /// τ.
        tau: f32,
    },
    /// Brightens the picture.
    Exposure {
        /// By so many stops.
        stops: f32,
    },
    /// How the screen shows light.
    View {
        /// Its name.
        name: Shown,
    },
    /// With noise or without.
    Denoise {
        /// Without.
        on: bool,
    },
    /// What is drawn of records.
    Marks {
        /// A dot where each is.
        dots: bool,
        /// The circle that it reaches.
        zones: bool,
    },
    /// Asks for the camera as a row of a path.
    Mark {},
    /// Begins to note the way of the camera, or ends.
    Record {
        /// Begins.
        on: bool,
    },
}

/// How a screen shows light, by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shown {
    /// [`View::Standard`].
    #[default]
    Standard,
    /// [`View::Agx`].
    Agx,
    /// [`View::Filmic`].
    Filmic,
}

impl From<Shown> for View {
    fn from(shown: Shown) -> Self {
        match shown {
            Shown::Standard => Self::Standard,
            Shown::Agx => Self::Agx,
            Shown::Filmic => Self::Filmic,
        }
    }
}

impl From<View> for Shown {
    fn from(view: View) -> Self {
        match view {
            View::Standard => Self::Standard,
            View::Agx => Self::Agx,
            View::Filmic => Self::Filmic,
        }
    }
}

/// What can be chosen, for the page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Menu {
    /// Name of the scene.
    pub scene: String,
    /// Methods: name, and what it does.
    pub methods: Vec<[String; 2]>,
    /// Who may sum the records of a pixel.
    pub interpolations: Vec<Interpolation>,
    /// The denoiser; `None` where there is none.
    pub denoiser: Option<String>,
    /// Where a recorded walk is written, if it is.
    pub record: Option<String>,
    /// Least and largest τ.
    pub taus: [f32; 2],
    /// Pixels of a whole frame.
    pub size: [u32; 2],
    /// Horizontal angle of view, radian; 0 where rays are parallel.
    pub fov: f32,
}

impl Menu {
    /// Refuses an order that cannot be followed: numbers that are not finite or far too large, a method that is not in the menu.
    ///
    /// # Errors
    /// One line for people.
    pub fn check(&self, command: &Command) -> Result<(), String> {
        let within = |what: &str, x: f64, most: f64| {
            if x.abs() <= most { Ok(()) } else { Err(format!("{what} must be a number from {} to {most}", -most)) }
        };
        match command {
            Command::Turn { yaw, pitch } => {
                within("yaw", *yaw, MOST_ANGLE).and_then(|()| within("pitch", *pitch, MOST_ANGLE))
            }
            Command::Step { forward, right, up } => [("forward", forward), ("right", right), ("up", up)]
                .iter()
                .try_for_each(|(w, x)| within(w, **x, MOST_WAY)),
            Command::Walk { forward, right, up } => {
                [("forward", forward), ("right", right), ("up", up)].iter().try_for_each(|(w, x)| within(w, **x, 1.0))
            }
            Command::Hurry { factor } if !(0.5..=2.0).contains(factor) => Err("factor must be from 0.5 to 2".into()),
            Command::Tau { tau } if !(self.taus[0]..=self.taus[1]).contains(tau) => {
                Err(format!("tau must be from {} to {}", self.taus[0], self.taus[1]))
            }
            Command::Exposure { stops } => within("stops", f64::from(*stops), f64::from(MOST_STOPS)),
            Command::Method { name } if !self.methods.iter().any(|[known, _]| known == name) => {
                Err("there is no such method".into())
            }
            Command::Interpolation { name } if !self.interpolations.contains(name) => {
                Err("nobody sums records so here".into())
            }
            Command::Denoise { on: true } if self.denoiser.is_none() => Err("there is no denoiser".into()),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_checked() {
        let menu = Menu {
            scene: "box".into(),
            methods: vec![["path".into(), String::new()]],
            interpolations: vec![Interpolation::Auto, Interpolation::Splat],
            denoiser: None,
            record: None,
            taus: TAUS,
            size: [512, 512],
            fov: 0.7,
        };
        let check = |text: &str| {
            let command: Command = serde_json::from_str(text).map_err(|e| e.to_string())?;
            menu.check(&command)
        };
        for good in [
            r#"{"do": "turn", "yaw": 0.5, "pitch": -1e-3}"#,
            r#"{"do": "walk", "forward": 1, "right": 0, "up": -1}"#,
            r#"{"do": "home"}"#,
            r#"{"do": "method", "name": "path"}"#,
            r#"{"do": "view", "name": "agx"}"#,
            r#"{"do": "interpolation", "name": "splat"}"#,
            r#"{"do": "tau", "tau": 0.1}"#,
        ] {
            assert_eq!(check(good), Ok(()), "{good}");
        }
        for bad in [
            r#"{"do": "turn", "yaw": 1e300, "pitch": 0}"#,
            r#"{"do": "turn", "yaw": 1e999, "pitch": 0}"#,
            r#"{"do": "turn", "yaw": null, "pitch": 0}"#,
            r#"{"do": "turn", "yaw": 0}"#,
            r#"{"do": "walk", "forward": 2, "right": 0, "up": 0}"#,
            r#"{"do": "step", "forward": 61, "right": 0, "up": 0}"#,
            r#"{"do": "hurry", "factor": 0}"#,
            r#"{"do": "tau", "tau": 0}"#,
            r#"{"do": "exposure", "stops": 1e30}"#,
            r#"{"do": "method", "name": "magic"}"#,
            r#"{"do": "view", "name": "../x"}"#,
            r#"{"do": "interpolation", "name": "both"}"#,
            r#"{"do": "interpolation", "name": "octree"}"#,
            r#"{"do": "denoise", "on": true}"#,
            r#"{"do": "home", "file": "/etc/passwd"}"#,
            r#"{"do": "fly"}"#,
            "[]",
            "",
        ] {
            assert!(check(bad).is_err(), "{bad}");
        }
    }
}
