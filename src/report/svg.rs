//! SVG text: shapes in, one self-contained file out.

use super::raster::PictureError;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use maud::Render;

/// Colours by role, so that a picture follows a reader's dark page. `tt` keeps the names from meeting others' where a
/// picture is inlined. Readers that know no media queries see the light one.
const STYLE: &str = ".tt{font-family:system-ui,-apple-system,'Segoe UI','Helvetica Neue',Arial,'DejaVu Sans',sans-serif;\
font-size:13px;font-variant-numeric:tabular-nums}\
.tt-page{fill:#ffffff}.tt-ink{fill:#1f2328}.tt-muted{fill:#59636e}.tt-title{fill:#1f2328;font-size:17px;font-weight:600}\
.tt-line{stroke:#1f2328;fill:none}.tt-hair{stroke:#c9d1d9;fill:none}.tt-wall{fill:#f6f8fa;stroke:#c9d1d9}\
@media (prefers-color-scheme:dark){\
.tt-page{fill:#161b22}.tt-ink{fill:#e6edf3}.tt-muted{fill:#9da7b1}.tt-title{fill:#e6edf3}\
.tt-line{stroke:#e6edf3}.tt-hair{stroke:#3d444d}.tt-wall{fill:#1c222a;stroke:#3d444d}}";

/// Where a text sits on its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A picture being drawn; y points down, the unit is a CSS pixel.
pub(super) struct Svg {
    body: String,
}

/// A coordinate to a hundredth of a pixel, without trailing zeros.
pub(super) fn coordinate(x: f64) -> String {
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

impl Svg {
    /// A picture of the given size with a title and a line below it; `title` is also its name for screen readers.
    pub fn new(width: f64, height: f64, title: &str, subtitle: &str) -> Self {
        let mut svg = Self { body: String::new() };
        let (w, h) = (coordinate(width), coordinate(height));
        let name = title.render().into_string();
        svg.push(&format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" class="tt" role="img" viewBox="0 0 {w} {h}" width="{w}" height="{h}"><title>{name}</title><style>{STYLE}</style>"#
        ));
        svg.rect([0.0, 0.0, width, height], r#"class="tt-page""#);
        svg.text([24.0, 32.0], Anchor::Start, "tt-title", title);
        svg.text([24.0, 53.0], Anchor::Start, "tt-muted", subtitle);
        svg
    }

    fn push(&mut self, text: &str) {
        self.body.push_str(text);
        self.body.push('\n');
    }

    /// A rectangle x, y, width, height with SVG attributes.
    pub fn rect(&mut self, [x, y, w, h]: [f64; 4], attributes: &str) {
        let [x, y, w, h] = [x, y, w, h].map(coordinate);
        self.push(&format!(r#"<rect x="{x}" y="{y}" width="{w}" height="{h}" {attributes}/>"#));
    }

    /// A line with SVG attributes.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], attributes: &str) {
        self.path(&[from, to], false, attributes);
    }

    /// A polyline, or a polygon where closed, with SVG attributes.
    pub fn path(&mut self, points: &[[f64; 2]], closed: bool, attributes: &str) {
        let mut d = String::new();
        let mut before = [0.0; 2];
        for (i, point) in points.iter().enumerate() {
            // A tenth of a pixel, and from the second point on the way from the one before: a relief has thousands.
            let tenths = point.map(|v| (v * 10.0).round());
            let [x, y] = [0, 1].map(|k| coordinate((tenths[k] - before[k]) / 10.0));
            let command = ["M", "l", if x.starts_with('-') { "" } else { " " }][i.min(2)];
            let gap = if y.starts_with('-') { "" } else { " " };
            d.push_str(&format!("{command}{x}{gap}{y}"));
            before = tenths;
        }
        if closed {
            d.push('Z');
        }
        // The quotes that a page's address need not escape.
        self.push(&format!("<path d='{d}' {attributes}/>"));
    }

    /// A path from its SVG commands, with SVG attributes.
    pub fn commands(&mut self, d: &str, attributes: &str) {
        self.push(&format!(r#"<path d="{d}" {attributes}/>"#));
    }

    /// Opens a part that is cut off at a rectangle x, y, width, height; close it with [`Svg::end_clip`].
    pub fn clip(&mut self, rectangle: [f64; 4]) {
        let [x, y, w, h] = rectangle.map(coordinate);
        self.push(&format!(r#"<svg x="{x}" y="{y}" width="{w}" height="{h}" viewBox="{x} {y} {w} {h}">"#));
    }

    /// Closes a part that is cut off.
    pub fn end_clip(&mut self) {
        self.push("</svg>");
    }

    /// Opens a group with SVG attributes; close it with [`Svg::end_group`].
    pub fn group(&mut self, attributes: &str) {
        self.push(&format!("<g {attributes}>"));
    }

    /// Closes a group.
    pub fn end_group(&mut self) {
        self.push("</g>");
    }

    /// A line of text with a class.
    pub fn text(&mut self, at: [f64; 2], anchor: Anchor, class: &str, text: &str) {
        self.text_with(at, anchor, &format!(r#"class="{class}""#), text);
    }

    /// A line of text running upward.
    pub fn text_upward(&mut self, at: [f64; 2], class: &str, text: &str) {
        let [x, y] = at.map(coordinate);
        self.text_with(at, Anchor::Middle, &format!(r#"class="{class}" transform="rotate(-90 {x} {y})""#), text);
    }

    /// A line of text with SVG attributes; it is escaped.
    pub fn text_with(&mut self, at: [f64; 2], anchor: Anchor, attributes: &str, text: &str) {
        let [x, y] = at.map(coordinate);
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = text.render().into_string();
        self.push(&format!(r#"<text x="{x}" y="{y}" text-anchor="{anchor}" {attributes}>{text}</text>"#));
    }

    /// A bar of the given length with end marks and a label to its right.
    pub fn scale_bar(&mut self, [x, y]: [f64; 2], length: f64, label: &str) {
        let bar = [[x, y - 5.0], [x, y + 5.0], [x, y], [x + length, y], [x + length, y - 5.0], [x + length, y + 5.0]];
        self.path(&bar, false, r#"class="tt-line" stroke-width="1.6""#);
        self.text([x + length + 10.0, y + 4.5], Anchor::Start, "tt-ink", label);
    }

    /// An RGB bitmap stretched over a rectangle x, y, width, height; large pixels keep their edges.
    pub fn bitmap(&mut self, place: [f64; 4], columns: usize, rows: usize, rgb: &[u8]) -> Result<(), PictureError> {
        self.bitmap_of(place, [columns, rows], rgb, ExtendedColorType::Rgb8)
    }

    /// An RGBA bitmap stretched over a rectangle x, y, width, height.
    pub fn bitmap_rgba(&mut self, place: [f64; 4], size: [usize; 2], rgba: &[u8]) -> Result<(), PictureError> {
        self.bitmap_of(place, size, rgba, ExtendedColorType::Rgba8)
    }

    fn bitmap_of(
        &mut self,
        [x, y, w, h]: [f64; 4],
        [columns, rows]: [usize; 2],
        pixels: &[u8],
        kind: ExtendedColorType,
    ) -> Result<(), PictureError> {
        let mut png = Vec::new();
        PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::Adaptive)
            .write_image(pixels, columns as u32, rows as u32, kind)
            .map_err(|e| PictureError::Bitmap(e.to_string()))?;
        let data = STANDARD.encode(png);
        let rendering = if w >= 3.0 * columns as f64 { r#" style="image-rendering:pixelated""# } else { "" };
        let [x, y, w, h] = [x, y, w, h].map(coordinate);
        self.push(&format!(
            r#"<image x="{x}" y="{y}" width="{w}" height="{h}" preserveAspectRatio="none"{rendering} href="data:image/png;base64,{data}"/>"#
        ));
        Ok(())
    }

    /// The finished file.
    pub fn finish(mut self) -> String {
        self.push("</svg>");
        self.body
    }
}

/// Width of a text in pixels at 13 px, for layout: a sans-serif letter is about 0.55 of the size wide.
pub(super) fn text_width(text: &str) -> f64 {
    7.2 * text.chars().count() as f64
}

/// Keeps a file that a test made where `TIRTOUCH_SAMPLES` names a folder: to be looked at, or read by other programs.
#[cfg(test)]
#[allow(clippy::unwrap_used)]
pub(super) fn keep_sample(name: &str, bytes: impl AsRef<[u8]>) {
    if let Ok(folder) = std::env::var("TIRTOUCH_SAMPLES") {
        std::fs::write(std::path::Path::new(&folder).join(name), bytes).unwrap();
    }
}

/// Checks for tests: every element closes, so that the file is XML.
#[cfg(test)]
#[allow(clippy::panic)]
pub(super) fn assert_well_formed(svg: &str) {
    let mut open = Vec::new();
    for tag in svg.split('<').skip(1) {
        let tag = tag.split('>').next().unwrap_or_default();
        let name: String = tag.trim_start_matches('/').chars().take_while(|c| c.is_alphanumeric()).collect();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "{tag}");
        } else if !tag.ends_with('/') {
            open.push(name);
        }
        let mut attributes: Vec<&str> =
            tag.split(' ').filter_map(|word| word.split_once("=\"")).map(|(name, _)| name).collect();
        attributes.sort_unstable();
        assert!(attributes.windows(2).all(|pair| pair[0] != pair[1]), "an attribute stands twice: {tag}");
    }
    assert!(open.is_empty(), "{open:?} left open");
    assert!(!svg.contains("NaN") && !svg.contains("inf\""), "a coordinate is not finite");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_elements_close() {
        let mut svg = Svg::new(100.0, 50.0, "a < b & c", "");
        svg.text([1.0, 2.0], Anchor::End, "tt-ink", "<script>");
        svg.path(&[[0.0, 0.0], [1.5, -0.001]], true, r#"class="tt-line""#);
        let text = svg.finish();
        assert_well_formed(&text);
        assert!(text.contains("a &lt; b &amp; c") && text.contains("&lt;script&gt;"));
        assert!(text.contains("d='M0 0l1.5 0Z'"), "{text}");
    }
}
