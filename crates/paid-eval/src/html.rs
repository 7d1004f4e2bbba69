//! One page that shows every result in a folder, without a network.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use crate::EvalError;
use crate::file::write_whole;
use crate::picture::escape;

/// Name of the page.
pub const REPORT: &str = "report.html";

const STYLE: &str = "body{font-family:sans-serif;max-width:76em;margin:2em auto;padding:0 1em;color:#222}\
pre{background:#f5f5f5;padding:1em;overflow-x:auto;font-size:85%}\
figure{display:inline-block;margin:0 1em 1em 0;vertical-align:top}figcaption{color:#666;font-size:85%}\
svg,img{max-width:100%;height:auto}";

/// Writes [`REPORT`] into `folder` from what earlier evaluations left there: every text table `NAME.txt` becomes a section, followed
/// by its pictures `NAME_*.svg` and by those `NAME_*.png` that have no vector twin.
///
/// # Errors
/// If the folder cannot be read or the page not be written.
pub fn write_report(folder: &Path) -> Result<(), EvalError> {
    let failed = |path: &Path, source| EvalError::Write { path: path.to_owned(), source };
    let entries = fs::read_dir(folder).map_err(|e| failed(folder, e))?;
    let mut files: Vec<PathBuf> = entries.filter_map(Result::ok).map(|entry| entry.path()).collect();
    files.sort();
    let has = |path: &Path, extension: &str| path.extension().is_some_and(|e| e == extension);
    let stem = |path: &Path| path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let mut body = String::new();
    for table in files.iter().filter(|f| has(f, "txt")) {
        let name = stem(table);
        let text = fs::read_to_string(table).map_err(|e| failed(table, e))?;
        // Writing to a string cannot fail.
        let _ = writeln!(body, "<h2>{}</h2>\n<pre>{}</pre>", escape(&name), escape(&text));
        let own = |f: &&PathBuf| stem(f).strip_prefix(&name).is_some_and(|rest| rest.starts_with('_'));
        for picture in files.iter().filter(own) {
            let drawn = if has(picture, "svg") {
                fs::read_to_string(picture).map_err(|e| failed(picture, e))?
            } else if has(picture, "png") && !picture.with_extension("svg").exists() {
                let bytes = fs::read(picture).map_err(|e| failed(picture, e))?;
                format!("<img alt=\"\" src=\"data:image/png;base64,{}\">", STANDARD.encode(bytes))
            } else {
                continue;
            };
            let caption = stem(picture);
            let _ = writeln!(body, "<figure>{drawn}<figcaption>{}</figcaption></figure>", escape(&caption));
        }
    }
    let page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>Evaluation</title><style>{STYLE}</style></head>\n\
         <body>\n<h1>Evaluation</h1>\n{body}</body>\n</html>\n"
    );
    write_whole(&folder.join(REPORT), page.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_come_with_their_own_pictures_and_vector_twins_win() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("writes");
        write("a_static.txt", "1 < 2");
        write("a_static_map.svg", "<svg id=\"map\"></svg>");
        write("a_static_map.png", "twin");
        write("a_static_paths.png", "abc");
        write("b.txt", "other");
        write("notes.json", "{}");
        write_report(folder.path()).expect("writes");
        let page = fs::read_to_string(folder.path().join(REPORT)).expect("the page");
        assert!(page.contains("<pre>1 &lt; 2</pre>") && page.contains("<svg id=\"map\">"), "{page}");
        assert!(page.contains("base64,YWJj\">"), "{page}");
        assert_eq!((page.matches("<figure>").count(), page.matches("<h2>").count()), (2, 2), "{page}");
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = write_report(Path::new("/no/such/folder")).expect_err("missing").to_string();
        assert!(error.contains("/no/such/folder"), "{error}");
    }
}
