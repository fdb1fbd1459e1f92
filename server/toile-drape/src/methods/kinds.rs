//! Kinds of garments that have a network of their own.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// A kind of garment that [`super::garnet`] is trained on.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GarmentKind {
    /// T-shirt.
    Tee,
    /// Sweater, or any loose top with long sleeves.
    Sweater,
    /// Dress with short sleeves.
    Dress,
    /// Jeans, or any long trousers.
    Jeans,
}

impl GarmentKind {
    /// Every kind, in the order of the API.
    pub const ALL: [Self; 4] = [Self::Tee, Self::Sweater, Self::Dress, Self::Jeans];

    /// The name in the API.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tee => "tee",
            Self::Sweater => "sweater",
            Self::Dress => "dress",
            Self::Jeans => "jeans",
        }
    }

    /// Its network.
    #[must_use]
    pub const fn graph(self) -> &'static str {
        match self {
            Self::Tee => "garnet/tee",
            Self::Sweater => "garnet/sweater",
            Self::Dress => "garnet/dress",
            Self::Jeans => "garnet/jeans",
        }
    }
}

impl fmt::Display for GarmentKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// No such kind.
#[derive(Debug, thiserror::Error)]
#[error("there is no kind of garment {0:?}; use tee, sweater, dress or jeans")]
pub struct UnknownKind(String);

impl FromStr for GarmentKind {
    type Err = UnknownKind;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL.into_iter().find(|k| k.name() == name).ok_or_else(|| UnknownKind(name.to_owned()))
    }
}
