//! Why numbers do not make a representation of the mean BRDF.

/// What is wrong with the parts that [`Zonal`](crate::zonal::Zonal), [`Cubature`](crate::cubature::Cubature),
/// [`Lobes`](crate::lobes::Lobes) or [`Paper`](crate::paper::Paper) was to be made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PartsError {
    /// The model is not a cosine lobe about the mirror direction.
    #[error("the model is not a lobe about the mirror direction")]
    NotRadial,
    /// Not as many numbers as the sizes ask for.
    #[error("{found} numbers, its sizes ask for {expected}")]
    Count {
        /// By the sizes.
        expected: usize,
        /// There are.
        found: usize,
    },
    /// Rows, columns, nodes or lobes out of range.
    #[error("{what} out of range")]
    Size {
        /// What is out of range.
        what: &'static str,
    },
    /// A number that cannot stand there.
    #[error("{what} {at} is no {what} of this representation")]
    Number {
        /// What it belongs to.
        what: &'static str,
        /// Its index among its like.
        at: usize,
    },
    /// The sizes do not fit the material: lobes for a diffuse one, or none for a glossy one.
    #[error("the representation does not fit the material")]
    Material,
}

impl PartsError {
    /// An error unless there are as many numbers as `expected`, or if that has no number (`None`: beyond `usize`).
    pub(crate) fn count(expected: Option<usize>, found: usize) -> Result<(), Self> {
        match expected {
            Some(expected) if expected == found => Ok(()),
            _ => Err(Self::Count { expected: expected.unwrap_or(usize::MAX), found }),
        }
    }

    /// An error for the first of some numbers that is not `valid`.
    pub(crate) fn first<T>(
        what: &'static str,
        of: impl IntoIterator<Item = T>,
        mut valid: impl FnMut(T) -> bool,
    ) -> Result<(), Self> {
        match of.into_iter().position(|x| !valid(x)) {
            Some(at) => Err(Self::Number { what, at }),
            None => Ok(()),
        }
    }
}
