//! Vector pictures.

use std::fmt::Write;

use super::Rgb;

/// A picture in the making. Coordinates are pixels from the top left.
#[derive(Clone, Debug)]
pub struct Svg {
    text: String,
}

const INK: Rgb = [30, 30, 30];

fn color(c: Rgb) -> String {
    format!("#{:02x}{:02x}{:02x}", c[0], c[1], c[2])
}

/// Text that may stand in XML and HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

impl Svg {
    /// A white picture.
    pub fn new(width: i64, height: i64) -> Self {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"sans-serif\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
        );
        Self { text }
    }

    fn push(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{element}");
    }

    /// A filled rectangle.
    pub fn rect(&mut self, at: [i64; 2], size: [i64; 2], fill: Rgb) {
        let ([x, y], [w, h]) = (at, size);
        self.push(format_args!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"{}\"/>",
            color(fill)
        ));
    }

    /// Dark text; `anchor` is `start`, `middle` or `end`.
    pub fn text(&mut self, x: i64, y: i64, size: i64, anchor: &str, text: &str) {
        self.colored_text([x, y], size, anchor, INK, text);
    }

    /// Text.
    pub fn colored_text(&mut self, at: [i64; 2], size: i64, anchor: &str, ink: Rgb, text: &str) {
        self.push(format_args!(
            "<text x=\"{}\" y=\"{}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{}\">{}</text>",
            at[0],
            at[1],
            color(ink),
            escape(text)
        ));
    }

    /// A line through points.
    pub fn line(&mut self, points: &[[f64; 2]], width: f64, ink: Rgb) {
        let mut list = String::new();
        for [x, y] in points {
            let _ = write!(list, "{x:.1},{y:.1} ");
        }
        self.push(format_args!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"/>",
            list.trim_end(),
            color(ink)
        ));
    }

    /// The file.
    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}
