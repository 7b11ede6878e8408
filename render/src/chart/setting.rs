//! How a method is run: the one number that a sweep varies.

use kit::number::number;
use std::fmt;

/// A setting of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// Seconds for everything but loading and fitting; the method finds its own quality.
    Time(f64),
    /// τ of a cached rendering.
    Tau(f32),
    /// Bands of every harmonic record, and τ of all else.
    Order(u8, f32),
    /// Sources of every EAS record, and τ of all else.
    Sources(u16, f32),
    /// Samples per pixel of the path tracer.
    Spp(u32),
}

impl Setting {
    /// τ, where it is given.
    pub fn tau(self) -> Option<f32> {
        match self {
            Self::Tau(tau) | Self::Order(_, tau) | Self::Sources(_, tau) => Some(tau),
            Self::Time(_) | Self::Spp(_) => None,
        }
    }
}

impl fmt::Display for Setting {
    /// As written in the CSV.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Time(seconds) => write!(f, "time={seconds}"),
            Self::Tau(tau) => write!(f, "tau={tau}"),
            Self::Order(order, tau) => write!(f, "order={order},tau={tau}"),
            Self::Sources(sources, tau) => write!(f, "sources={sources},tau={tau}"),
            Self::Spp(n) => write!(f, "spp={n}"),
        }
    }
}

/// A parser of seconds, each as much as a `Duration` takes.
pub fn parse_time() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    number(1e-9..=1e7, "seconds > 0")
}

/// A parser of τ, as a rendering takes it.
pub fn parse_tau() -> impl Fn(&str) -> Result<f32, String> + Clone + Send + Sync + 'static {
    number(0.0005..=1.0, "a number from 0.0005 to 1")
}
