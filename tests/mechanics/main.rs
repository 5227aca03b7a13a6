//! The closed forms of elasticity and contact, reproduced by the press's elements, laws and contact.
//!
//! `answers` poses problems on ladders of meshes; the tests hold a rung to a tolerance. Rates are asserted where the
//! solution is smooth; elsewhere the tolerance is that of the answer's source, or the error measured one rung lower.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod answers;
mod estimates;
mod extreme_presses;
mod extremes;
mod faults;
mod friction;
mod inclusion;
mod indenters;
mod laws;
mod layers;
mod locking;
mod manufactured;
mod multigrid;
mod patch;
mod press;
mod punches;
mod rates;
mod relaxation;
mod shells;
mod sliding;
mod wall;

impl answers::Answer {
    /// Error of a figure, relative where the exact value is not 0.
    fn error(&self, name: &str) -> f64 {
        self.figures.iter().find(|figure| figure.name == name).map(answers::Figure::error).unwrap()
    }
}
