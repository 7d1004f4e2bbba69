//! Parts of a page that needs no network: figures, bars, the frame around them.

mod bars;

use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use paid_files::FileError;

use crate::escape;

pub use bars::{Bar, bars};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// A whole page: its title (plain text), links to its sections and the sections, both HTML.
pub fn page(title: &str, links: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>{0}</title><style>{STYLE}</style></head>\n<body>\n<h1>{0}</h1>\n<nav>{links}</nav>\n{body}<script>{SCRIPT}</script>\
         </body>\n</html>\n",
        escape(title)
    )
}

/// The beginning of a chart as SVG in the page's own colors and typeface, to be closed by `</svg>`.
pub fn begin_chart(width: f64, height: f64, title: &str) -> String {
    format!(
        "<svg class=\"chart\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\">\
         <title>{}</title>\n",
        escape(title)
    )
}

/// An image with its caption.
pub fn figure(drawn: &str, caption: &str) -> String {
    format!("<figure>{drawn}<figcaption>{}</figcaption></figure>\n", escape(caption))
}

/// `NAME.svg`, or `NAME.png` if there is none, as a part of the page; `None` without either.
///
/// # Errors
/// If the file cannot be read.
pub fn embedded(name: &Path) -> Result<Option<String>, FileError> {
    let file = |extension: &str| {
        let mut path = name.as_os_str().to_owned();
        path.push(extension);
        PathBuf::from(path)
    };
    let (svg, png) = (file(".svg"), file(".png"));
    if svg.is_file() {
        return fs::read_to_string(&svg).map(Some).map_err(FileError::at(&svg));
    }
    if !png.is_file() {
        return Ok(None);
    }
    let bytes = fs::read(&png).map_err(FileError::at(&png))?;
    Ok(Some(format!(
        "<img alt=\"\" loading=\"lazy\" src=\"data:image/png;base64,{}\">",
        STANDARD.encode(bytes)
    )))
}
