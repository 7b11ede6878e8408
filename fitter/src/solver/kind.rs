//! The solvers by name.

use std::fmt;
use std::str::FromStr;

use super::{Bfgs, GaussNewton, Genetic, GeneticPolished, LevenbergMarquardt, NelderMead, Options, Solver};

/// One of the optimisers of this module.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SolverKind {
    /// [`LevenbergMarquardt`], `lm`.
    LevenbergMarquardt,
    /// [`Genetic`], `ga`.
    Genetic,
    /// [`GeneticPolished`], `ga-lm`.
    GeneticPolished,
    /// [`NelderMead`], `nelder-mead`.
    NelderMead,
    /// [`GaussNewton`], `gauss-newton`.
    GaussNewton,
    /// [`Bfgs`], `bfgs`.
    Bfgs,
}

impl SolverKind {
    /// Every kind, the work horse first.
    pub const ALL: [Self; 6] = [
        Self::LevenbergMarquardt,
        Self::Genetic,
        Self::GeneticPolished,
        Self::NelderMead,
        Self::GaussNewton,
        Self::Bfgs,
    ];

    /// The solver itself.
    pub fn with(self, options: Options) -> Box<dyn Solver> {
        match self {
            Self::LevenbergMarquardt => Box::new(LevenbergMarquardt { options }),
            Self::Genetic => Box::new(Genetic { options }),
            Self::GeneticPolished => Box::new(GeneticPolished { options }),
            Self::NelderMead => Box::new(NelderMead { options }),
            Self::GaussNewton => Box::new(GaussNewton { options }),
            Self::Bfgs => Box::new(Bfgs { options }),
        }
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        self.with(Options::default()).name()
    }

    /// Whether the result depends on the seed.
    pub fn is_random(self) -> bool {
        matches!(self, Self::Genetic | Self::GeneticPolished)
    }
}

impl fmt::Display for SolverKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The name is none of the solvers'.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown solver `{name}`, expected one of {known}", known = known_names())]
pub struct UnknownSolver {
    name: String,
}

fn known_names() -> String {
    SolverKind::ALL.map(SolverKind::name).join(", ")
}

impl FromStr for SolverKind {
    type Err = UnknownSolver;

    fn from_str(name: &str) -> Result<Self, UnknownSolver> {
        let known = Self::ALL.into_iter().find(|kind| kind.name() == name);
        known.ok_or_else(|| UnknownSolver { name: name.into() })
    }
}
