//! The points of a sweep, to be gone through one by one.

use serde::Serialize;

/// Points of a sweep.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Points {
    /// Names of what varies and of the figures, with units where they have some.
    pub names: Vec<String>,
    /// Of them the only one that varies by itself, if there is one: the points are gone through along it.
    pub along: Option<usize>,
    /// The points that are done, in the order of the design.
    pub points: Vec<Point>,
}

/// A point.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Point {
    /// Its row in the design.
    pub row: usize,
    /// What it has of each name.
    pub values: Vec<String>,
    /// Its images: file beside the page, and load in words.
    pub images: Vec<[String; 2]>,
}
