//! Where a sensor touches.

/// Outline of the contact, centred on the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Footprint {
    /// A disc.
    Round {
        /// Its radius, mm.
        radius_mm: f64,
    },
    /// A rectangle along the axes.
    Rectangle {
        /// Half its widths along x and y, mm.
        half_widths_mm: [f64; 2],
    },
}
