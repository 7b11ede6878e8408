//! What can be wrong with a material.

/// Why a material is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MaterialError {
    /// A parameter is not a number of its range.
    #[error("{key} is {value}, outside {min}..={max}")]
    Range {
        /// Parameter.
        key: &'static str,
        /// Its value.
        value: f64,
        /// Smallest allowed value.
        min: f64,
        /// Largest allowed value.
        max: f64,
    },
    /// A parameter holds something else than it should.
    #[error("{key} must be {expected}")]
    Kind {
        /// Parameter.
        key: &'static str,
        /// What it holds when right.
        expected: String,
    },
    /// There is no such model.
    #[error("unknown model {name:?}, expected one of {}", known.join(", "))]
    Model {
        /// The name given.
        name: String,
        /// The names there are.
        known: Vec<&'static str>,
    },
    /// A parameter without default is absent.
    #[error("{key} is missing")]
    Missing {
        /// Parameter, or the alternatives.
        key: &'static str,
    },
    /// Two parameters exclude each other.
    #[error("{key} and {other} exclude each other")]
    Conflict {
        /// One parameter.
        key: &'static str,
        /// The other.
        other: &'static str,
    },
    /// A Lafortune lobe that reaches further than single precision can follow.
    #[error("{key}: lobe {lobe} exceeds 1e9 per steradian")]
    Peak {
        /// Parameter.
        key: &'static str,
        /// Which lobe, from 1.
        lobe: usize,
    },
    /// More light leaves than arrives already at normal incidence.
    #[error("the albedo at normal incidence is {albedo:.4} in channel {channel}: kd and ks are too large together")]
    Energy {
        /// `'r'`, `'g'` or `'b'`.
        channel: char,
        /// Albedo, more than 1.
        albedo: f64,
    },
}

impl MaterialError {
    /// The recipe key to blame, if it is one.
    pub fn key(&self) -> Option<&'static str> {
        match *self {
            Self::Range { key, .. } | Self::Kind { key, .. } | Self::Conflict { key, .. } | Self::Peak { key, .. } => {
                Some(key)
            }
            Self::Model { .. } => Some("model"),
            Self::Missing { .. } | Self::Energy { .. } => None,
        }
    }
}
