//! Pictures and the report.
//!
//! Pictures are SVG text: self-contained, in light and dark (they follow the reader's preference), bitmaps inlined as
//! PNG. The report is one HTML file with the pictures inside.

mod axes;
pub mod bars;
pub mod curves;
pub mod explore;
pub mod false_color;
pub mod frame_pictures;
pub mod heat_map;
pub mod html;
pub mod log_plot;
mod marks;
pub mod mesh_picture;
pub mod raster;
pub mod relief;
pub mod side_view;
mod svg;
mod ticks;
pub mod vtu;

pub use axes::AxisName;
pub use bars::{Bar, BarPlot, bar_plot};
pub use curves::{Curve, CurvePlot, CurveStyle, curve_plot};
pub(crate) use false_color::color as color_of;
pub use false_color::{ColorScale, false_color, false_color_with};
pub use frame_pictures::{FramePicture, frame_picture, frames_image};
pub use heat_map::{HeatMap, heat_map};
pub use html::{Item, Report, Section, Table};
pub use log_plot::{LogPlot, LogPoint, LogSeries, LogStyle, log_plot};
pub use marks::Marks;
pub use mesh_picture::{MeshBody, MeshPicture, MeshValues, mesh_picture};
pub use raster::{PictureError, Raster};
pub use relief::relief;
pub use side_view::{Fate, RayPolyline, SideView, side_view};
pub use vtu::{Values, Vtu, VtuError};
