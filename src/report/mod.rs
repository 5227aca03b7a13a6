//! Pictures and the report.
//!
//! Pictures are SVG text: self-contained, in light and dark (they follow the reader's preference), bitmaps inlined as
//! PNG. The report is one HTML file with the pictures inside.

pub mod false_color;
pub mod html;
pub mod raster;
pub mod relief;
pub mod side_view;
mod svg;
mod ticks;
pub mod vtu;

pub use false_color::{ColorScale, false_color};
pub use html::{Item, Report, Section, Table};
pub use raster::{PictureError, Raster};
pub use relief::relief;
pub use side_view::{Fate, RayPolyline, SideView, side_view};
