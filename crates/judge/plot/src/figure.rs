//! Charts as lists of shapes: one description, drawn as pixels (PNG) and as vectors (SVG).

use std::fmt::Write;
use std::path::Path;

use paid_files::write_whole;

use crate::{Canvas, PlotError, Rgb};

const INK: Rgb = [30, 30, 30];

/// Where a text stands against its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// A chart on a white ground. Coordinates are pixels from the top left; later shapes cover earlier ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    width: i64,
    height: i64,
    shapes: Vec<Shape>,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Rect {
        at: [i64; 2],
        size: [i64; 2],
        fill: Rgb,
    },
    Disc {
        center: [f64; 2],
        radius: f64,
        fill: Rgb,
    },
    Line {
        points: Vec<[f64; 2]>,
        width: i64,
        ink: Rgb,
        /// Share of the ink, 0 to 1; less than 1 is seen through.
        cover: f64,
    },
    /// `at` is on the baseline; `size` is the font's in pixels.
    Text {
        at: [i64; 2],
        size: i64,
        anchor: Anchor,
        ink: Rgb,
        text: String,
    },
}

fn color(c: Rgb) -> String {
    format!("#{:02x}{:02x}{:02x}", c[0], c[1], c[2])
}

/// Text that may stand in XML and HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

impl Figure {
    /// An empty chart.
    pub fn new(width: i64, height: i64) -> Self {
        Self { width, height, shapes: Vec::new() }
    }
    /// Width and height in pixels.
    pub fn size(&self) -> [i64; 2] {
        [self.width, self.height]
    }
    /// A filled rectangle; `at` is its top left corner.
    pub fn rect(&mut self, at: [i64; 2], size: [i64; 2], fill: Rgb) {
        self.shapes.push(Shape::Rect { at, size, fill });
    }
    /// A filled disc.
    pub fn disc(&mut self, center: [f64; 2], radius: f64, fill: Rgb) {
        self.shapes.push(Shape::Disc { center, radius, fill });
    }
    /// A line through points, `width` pixels wide.
    pub fn line(&mut self, points: Vec<[f64; 2]>, width: i64, ink: Rgb) {
        self.shapes.push(Shape::Line { points, width, ink, cover: 1.0 });
    }
    /// A line that covers what is below it by a share `cover`, so that many of them show where most are.
    pub fn trace(&mut self, points: Vec<[f64; 2]>, width: i64, ink: Rgb, cover: f64) {
        self.shapes.push(Shape::Line { points, width, ink, cover });
    }
    /// Dark text with its baseline at `at`, in a font of `size` pixels.
    pub fn text(&mut self, at: [i64; 2], size: i64, anchor: Anchor, text: &str) {
        self.colored_text(at, size, anchor, INK, text);
    }
    /// Text of any color.
    pub fn colored_text(&mut self, at: [i64; 2], size: i64, anchor: Anchor, ink: Rgb, text: &str) {
        self.shapes.push(Shape::Text { at, size, anchor, ink, text: text.to_owned() });
    }
    /// Copies another chart with its top left corner at `at`.
    pub fn place(&mut self, at: [i64; 2], other: &Self) {
        let [x, y] = at;
        let (fx, fy) = (x as f64, y as f64);
        self.shapes.extend(other.shapes.iter().cloned().map(|mut shape| {
            match &mut shape {
                Shape::Rect { at, .. } | Shape::Text { at, .. } => *at = [at[0] + x, at[1] + y],
                Shape::Disc { center, .. } => *center = [center[0] + fx, center[1] + fy],
                Shape::Line { points, .. } => points.iter_mut().for_each(|p| *p = [p[0] + fx, p[1] + fy]),
            }
            shape
        }));
    }
    /// Charts in rows of `columns`, each in a cell as large as the largest of them.
    pub fn tiled(charts: &[Self], columns: usize) -> Self {
        let largest = |k: usize| charts.iter().map(|c| c.size()[k]).max().unwrap_or(0);
        let (width, height) = (largest(0), largest(1));
        let columns = columns.clamp(1, charts.len().max(1));
        let rows = charts.len().div_ceil(columns);
        let mut all = Self::new(width * columns as i64, height * rows as i64);
        for (i, chart) in charts.iter().enumerate() {
            all.place([width * (i % columns) as i64, height * (i / columns) as i64], chart);
        }
        all
    }

    /// The pixels.
    pub fn canvas(&self) -> Canvas {
        let mut image = Canvas::new(self.width.max(1) as usize, self.height.max(1) as usize, [255; 3]);
        for shape in &self.shapes {
            match shape {
                Shape::Rect { at, size, fill } => image.rect(at[0], at[1], size[0], size[1], *fill),
                Shape::Disc { center, radius, fill } => image.disc(*center, *radius, *fill),
                Shape::Line { points, width, ink, cover } => image.polyline(points, *width, *ink, *cover),
                Shape::Text { at, size, anchor, ink, text } => {
                    let [w, h] = Canvas::text_size(*size, text);
                    let back = match anchor {
                        Anchor::Start => 0,
                        Anchor::Middle => w / 2,
                        Anchor::End => w,
                    };
                    image.text(at[0] - back, at[1] - h, *size, *ink, text);
                }
            }
        }
        image
    }

    /// The SVG file.
    pub fn svg(&self) -> String {
        let (w, h) = (self.width, self.height);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"sans-serif\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n"
        );
        for shape in &self.shapes {
            // Writing to a string cannot fail.
            let _ = match shape {
                Shape::Rect { at: [x, y], size: [w, h], fill } => writeln!(
                    out,
                    "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"{}\"/>",
                    color(*fill)
                ),
                Shape::Disc { center: [x, y], radius, fill } => {
                    writeln!(
                        out,
                        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{}\"/>",
                        color(*fill)
                    )
                }
                Shape::Line { points, width, ink, cover } => {
                    let list: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
                    let seen =
                        if *cover < 1.0 { format!(" stroke-opacity=\"{cover}\"") } else { String::new() };
                    writeln!(
                        out,
                        "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"{seen}/>",
                        list.join(" "),
                        color(*ink)
                    )
                }
                Shape::Text { at: [x, y], size, anchor, ink, text } => {
                    let anchor = match anchor {
                        Anchor::Start => "start",
                        Anchor::Middle => "middle",
                        Anchor::End => "end",
                    };
                    writeln!(
                        out,
                        "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{}\">{}</text>",
                        color(*ink),
                        escape(text)
                    )
                }
            };
        }
        out.push_str("</svg>\n");
        out
    }

    /// Writes `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn save(&self, stem: &Path) -> Result<(), PlotError> {
        let file = |extension: &str| {
            let mut name = stem.as_os_str().to_owned();
            name.push(extension);
            std::path::PathBuf::from(name)
        };
        self.canvas().save(&file(".png"))?;
        Ok(write_whole(&file(".svg"), self.svg().as_bytes())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Rgb = [200, 0, 0];

    #[test]
    fn both_forms_show_the_same_shapes() {
        let mut figure = Figure::new(60, 40);
        figure.rect([2, 3], [10, 20], RED);
        figure.line(vec![[20.0, 5.0], [20.0, 30.0], [50.0, 30.0]], 1, [0, 0, 200]);
        figure.disc([40.0, 10.0], 3.0, [0, 200, 0]);
        figure.text([59, 39], 14, Anchor::End, "a & b");
        let (image, svg) = (figure.canvas(), figure.svg());
        assert_eq!((image.width(), image.height()), (60, 40));
        assert_eq!((image.get(2, 3), image.get(11, 22), image.get(12, 3)), (RED, RED, [255; 3]));
        assert_eq!((image.get(20, 20), image.get(40, 10)), ([0, 0, 200], [0, 200, 0]));
        assert!(svg.contains("<rect x=\"2\" y=\"3\" width=\"10\" height=\"20\" fill=\"#c80000\"/>"), "{svg}");
        assert!(svg.contains("points=\"20.0,5.0 20.0,30.0 50.0,30.0\"") && svg.contains("<circle "), "{svg}");
        assert!(svg.contains("text-anchor=\"end\"") && svg.contains(">a &amp; b</text>"), "{svg}");
        // The last letter ends at the anchor and stands on the baseline.
        assert!((48..59).any(|x| (28..39).any(|y| image.get(x, y) == INK)));
        assert!((0..60).all(|x| image.get(x, 39) == [255; 3]));
    }

    #[test]
    fn tiles_do_not_overlap() {
        let mut small = Figure::new(10, 10);
        small.rect([0, 0], [10, 10], RED);
        let all = Figure::tiled(&[small.clone(), Figure::new(20, 30), small.clone()], 2);
        assert_eq!(all.size(), [40, 60]);
        let image = all.canvas();
        assert_eq!((image.get(0, 0), image.get(5, 35)), (RED, RED));
        assert_eq!((image.get(15, 5), image.get(25, 5)), ([255; 3], [255; 3]));
    }

    #[test]
    fn both_files_are_written() {
        let folder = tempfile::tempdir().expect("a folder");
        Figure::new(8, 8).save(&folder.path().join("a.b")).expect("writes");
        for name in ["a.b.png", "a.b.svg"] {
            assert!(folder.path().join(name).is_file(), "{name}");
        }
    }
}
