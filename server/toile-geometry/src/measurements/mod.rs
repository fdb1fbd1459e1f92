//! The tailor's measurements of a body, and the body of given measurements.
//!
//! Where each tape lies, after ISO 8559-1:2017, is fixed by `model/body/measurements.py` and baked into
//! the body file; here tapes are read, measured and solved for. Centimetres and kilograms.

pub(crate) mod cholesky;
mod linear_points;
mod solve;
mod tape;
mod units;

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::body::{Body, BodyError, ShapedBody};

pub use solve::{Solution, solve};
pub use tape::{Tape, TapeKind, TapeSource, VolumeFit};

/// What can be measured, in the order of the body file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs, reason = "names and descriptions come with `MeasurementInfo`")]
pub enum Measurement {
    Height,
    Weight,
    Chest,
    Underbust,
    Waist,
    Hip,
    Inseam,
    ShoulderWidth,
    ArmLength,
    Neck,
    Thigh,
}

/// Number of measurements.
pub const MEASUREMENTS: usize = Measurement::ALL.len();

impl Measurement {
    /// All measurements, in order.
    pub const ALL: [Self; 11] = [
        Self::Height,
        Self::Weight,
        Self::Chest,
        Self::Underbust,
        Self::Waist,
        Self::Hip,
        Self::Inseam,
        Self::ShoulderWidth,
        Self::ArmLength,
        Self::Neck,
        Self::Thigh,
    ];

    /// The name at the API.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Height => "height",
            Self::Weight => "weight",
            Self::Chest => "chest",
            Self::Underbust => "underbust",
            Self::Waist => "waist",
            Self::Hip => "hip",
            Self::Inseam => "inseam",
            Self::ShoulderWidth => "shoulder_width",
            Self::ArmLength => "arm_length",
            Self::Neck => "neck",
            Self::Thigh => "thigh",
        }
    }

    /// The unit of its values.
    #[must_use]
    pub fn unit(self) -> &'static str {
        if self == Self::Weight { "kg" } else { "cm" }
    }
}

impl fmt::Display for Measurement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Measurement {
    type Err = MeasurementError;

    /// By name; `bust` is another name of `chest`.
    fn from_str(name: &str) -> Result<Self, MeasurementError> {
        let known = if name == "bust" { "chest" } else { name };
        let found = Self::ALL.into_iter().find(|m| m.name() == known);
        found.ok_or_else(|| MeasurementError::Unknown { name: name.to_owned() })
    }
}

/// A measurement as it is shown to people. Values in its `unit`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct MeasurementInfo {
    /// The name at the API.
    pub name: String,
    /// For people.
    pub label: String,
    /// `cm` or `kg`.
    pub unit: String,
    /// Smallest value that is taken.
    pub min: f32,
    /// Largest value that is taken.
    pub max: f32,
    /// The reference body's own.
    pub default: f32,
    /// Where the tape lies, with the clause of ISO 8559-1.
    pub description: String,
}

/// A value for every measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measurements([f32; MEASUREMENTS]);

impl Measurements {
    /// The value of one, cm or kg.
    #[must_use]
    pub fn get(&self, measurement: Measurement) -> f32 {
        self.0[measurement as usize]
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = (Measurement, f32)> {
        Measurement::ALL.into_iter().zip(self.0)
    }
}

/// Why there is no body of the measurements asked for.
#[derive(Debug, Error)]
pub enum MeasurementError {
    /// There is no such measurement.
    #[error("there is no measurement named {name:?}")]
    Unknown {
        /// The name asked for.
        name: String,
    },
    /// One measurement under both of its names.
    #[error("{name} is given twice, as chest and as bust")]
    Twice {
        /// The measurement.
        name: Measurement,
    },
    /// No adult measures that, but one would in another unit.
    #[error("{name} is {value} {}; did you mean {meant} {}?", name.unit(), name.unit())]
    Units {
        /// The measurement.
        name: Measurement,
        /// The value asked for.
        value: f32,
        /// What it would be in the right unit.
        meant: f32,
    },
    /// No adult measures that.
    #[error("{name} is {value} {}; it must be between {min} and {max} {}", name.unit(), name.unit())]
    OutOfRange {
        /// The measurement.
        name: Measurement,
        /// The value asked for.
        value: f32,
        /// Smallest value.
        min: f32,
        /// Largest value.
        max: f32,
    },
    /// No body has these measurements together; these are the ones that come out wrong.
    #[error("no body has these measurements together: {}", describe(misses))]
    Unreachable {
        /// What misses by too much, the worst first.
        misses: Vec<Miss>,
    },
    /// A phenotype that was given besides is wrong.
    #[error(transparent)]
    Phenotype(#[from] BodyError),
}

/// A measurement that cannot be had, and how near a body comes. cm or kg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Miss {
    /// The measurement.
    pub name: Measurement,
    /// The value asked for.
    pub requested: f32,
    /// The nearest body's.
    pub achieved: f32,
}

fn describe(misses: &[Miss]) -> String {
    let one = |m: &Miss| {
        format!("{} {} {unit} (nearest {:.1} {unit})", m.name, m.requested, m.achieved, unit = m.name.unit())
    };
    misses.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Values by name -> values by measurement.
///
/// # Errors
/// [`MeasurementError::Unknown`] and [`MeasurementError::Twice`].
pub fn by_measurement(
    values: &BTreeMap<String, f32>,
) -> Result<BTreeMap<Measurement, f32>, MeasurementError> {
    let mut out = BTreeMap::new();
    for (name, &value) in values {
        let measurement = name.parse()?;
        if out.insert(measurement, value).is_some() {
            return Err(MeasurementError::Twice { name: measurement });
        }
    }
    Ok(out)
}

/// Measures a body.
#[must_use]
pub fn measure(body: &Body, shaped: &ShapedBody) -> Measurements {
    let coefficients = body.terms().coefficients(&shaped.shape);
    Measurements(body.tape().measure(&coefficients, shaped.shape.offsets()).map(|value| value as f32))
}
