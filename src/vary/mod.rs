//! What varies from point to point: keys of a scene, their values or distributions, constraints, and the design of
//! points. Sweeps vary by it, and whatever else asks many scenes of one: each point is a valid scene of its own.

mod columns;
mod design;
mod distribution;
mod expression;
mod key;
mod kinds;
mod plan;
mod scalar;
pub mod sensitivity;
mod set;

pub use design::{Design, MOST_POINTS};
pub use expression::{Expression, FUNCTIONS};
pub use key::KeyPath;
pub use plan::{Plan, Point};
pub use scalar::Scalar;
pub(crate) use set::key_and_value;
pub use set::{Set, with, with_scan};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A variable: an entry of `[[vary]]`. It has one of `fixed`, `values`, `linear`, `log`, `uniform`, `log_uniform`,
/// `normal`, `log_normal`, `choice` and `expression`, or none where the design's table has its column.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vary {
    /// Name in expressions and tables. Default: the key.
    pub name: Option<String>,
    /// The key of the scene that takes the value, as in `stack.layer[0].n`; a list of keys ties them together. Absent:
    /// a number for expressions alone.
    pub key: Option<Keys>,
    /// The same value everywhere.
    pub fixed: Option<Scalar>,
    /// The values of an axis.
    pub values: Option<Vec<Scalar>>,
    /// Values from one to another in even steps.
    pub linear: Option<Range>,
    /// Values from one to another in even ratios.
    pub log: Option<Range>,
    /// Drawn evenly from low to high.
    pub uniform: Option<[f64; 2]>,
    /// Drawn from low to high, evenly in the logarithm.
    pub log_uniform: Option<[f64; 2]>,
    /// Drawn from a normal distribution.
    pub normal: Option<Normal>,
    /// Drawn from a log-normal distribution; `mean` and `sd` are those of the quantity, not of its logarithm.
    pub log_normal: Option<Normal>,
    /// One of these, each as often.
    pub choice: Option<Vec<Scalar>>,
    /// Computed from the other variables, as in `n_top - 0.01`.
    pub expression: Option<String>,
}

/// Values between two, both included.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// The first.
    pub from: f64,
    /// The last.
    pub to: f64,
    /// How many.
    pub points: u32,
}

/// A normal distribution, or what lies of it between two bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Normal {
    /// Mean, before it is cut.
    pub mean: f64,
    /// Standard deviation, before it is cut.
    pub sd: f64,
    /// Lowest value. Absent: none.
    pub low: Option<f64>,
    /// Highest value. Absent: none.
    pub high: Option<f64>,
}

/// A constraint: an entry of `[[require]]`. Points that break it are not computed, and say why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Require {
    /// What must hold, as in `depth + size < 18`.
    pub expression: String,
    /// Why, for the points that break it. Default: the expression.
    pub reason: Option<String>,
}

/// One key or several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Keys {
    /// One.
    One(String),
    /// Several that take the same value.
    Tied(Vec<String>),
}

impl JsonSchema for Keys {
    fn schema_name() -> Cow<'static, str> {
        "Keys".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": ["string", "array"], "items": {"type": "string"}})
    }
}

impl Keys {
    /// All of them.
    pub fn all(&self) -> &[String] {
        match self {
            Self::One(key) => std::slice::from_ref(key),
            Self::Tied(keys) => keys,
        }
    }
}
