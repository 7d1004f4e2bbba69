//! One page that shows every result in a folder, without a network.

mod mouth;
mod shots;

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use paid_files::{FileError, write_whole};
use paid_plot::escape;
use paid_plot::html::{embedded, figure, page};

use crate::EvalError;

/// Name of the page.
pub const REPORT: &str = "report.html";

/// A first line of a table beyond this states the protocol and is folded [characters].
const LONG: usize = 120;

/// Writes [`REPORT`] into `folder` from what earlier evaluations left there: every text table `NAME.txt` becomes a section. One with
/// `NAME_shooting.json` next to it starts with the score and its interval next to the paper's, then come heat maps, the goal's mouth, paths,
/// the worst shots and a table that sorts. Any other is followed by its images `NAME_*.svg`, by those `NAME_*.png` that have no
/// vector twin, and by the film strips that `NAME_strips.json` lists.
///
/// # Errors
/// If the folder cannot be read or the page not be written.
pub fn write_report(folder: &Path) -> Result<(), EvalError> {
    let entries = fs::read_dir(folder).map_err(FileError::at(folder))?;
    let mut files: Vec<PathBuf> = entries.filter_map(Result::ok).map(|entry| entry.path()).collect();
    // What has a headline comes first, balls at rest before rolling ones, as in the paper.
    let shooting = |file: &Path| folder.join(format!("{}_shooting.json", stem(file))).is_file();
    files.sort_by_key(|file| (!shooting(file), stem(file).contains("rolling"), file.clone()));
    let (mut body, mut links) = (String::new(), String::new());
    for table in files.iter().filter(|file| has(file, "txt")) {
        let name = stem(table);
        let text = fs::read_to_string(table).map_err(FileError::at(table))?;
        let json = fs::read_to_string(folder.join(format!("{name}_shooting.json"))).unwrap_or_default();
        let section = match shots::section(folder, &name, &json, &text)? {
            Some(section) => section,
            None => {
                let strips = shots::strips(folder, &format!("{name}_strips.json"), "film strips")?;
                plain(&name, &text, &files)? + &strips
            }
        };
        body.push_str(&section);
        // Writing to a string cannot fail.
        let _ = write!(links, "<a href=\"#{0}\">{0}</a>", escape(&name));
    }
    let title =
        folder.file_name().map_or_else(|| "Evaluation".to_owned(), |n| n.to_string_lossy().into_owned());
    let page = page(&title, &links, &body);
    Ok(write_whole(&folder.join(REPORT), page.as_bytes())?)
}

/// A table and the images that belong to it.
fn plain(name: &str, text: &str, files: &[PathBuf]) -> Result<String, EvalError> {
    let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
    let (protocol, table) =
        if first.len() > LONG { (shots::protocol(first), rest.trim_start()) } else { (String::new(), text) };
    let mut out = format!(
        "<h2 id=\"{0}\">{0}</h2>\n{protocol}<pre>{1}</pre>\n<div class=\"row\">",
        escape(name),
        escape(table)
    );
    let own = |f: &&PathBuf| stem(f).strip_prefix(name).is_some_and(|rest| rest.starts_with('_'));
    for picture in files.iter().filter(own) {
        let twin = has(picture, "png") && picture.with_extension("svg").exists();
        if !twin && let Some(drawn) = embedded(&picture.with_extension(""))? {
            out.push_str(&figure(&drawn, &stem(picture)));
        }
    }
    out.push_str("</div>\n");
    Ok(out)
}

fn has(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e == extension)
}

fn stem(path: &Path) -> String {
    path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::{Effort, Timing};
    use crate::results::{Evaluation, to_json, write_shooting};
    use crate::shooting::CellScore;
    use crate::shooting::report_tests::report;
    use crate::worst::{Strip, write_strips};

    #[test]
    fn tables_come_with_their_own_pictures_and_vector_twins_win() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("writes");
        write("a_static.txt", "1 < 2");
        write("a_static_map.svg", "<svg id=\"map\"></svg>");
        write("a_static_map.png", "twin");
        write("a_static_paths.png", "abc");
        write("b.txt", "other");
        fs::create_dir(folder.path().join("c")).expect("made");
        write("c/goal.png", "def");
        write("b_strips.json", r#"[{"picture": "c/goal.png", "words": "a goal"}]"#);
        write("notes.json", "{}");
        write_report(folder.path()).expect("writes");
        let page = fs::read_to_string(folder.path().join(REPORT)).expect("the page");
        assert!(page.contains("<pre>1 &lt; 2</pre>") && page.contains("<svg id=\"map\">"), "{page}");
        assert!(page.contains("base64,YWJj\">"), "{page}");
        assert!(page.contains("base64,ZGVm\">") && page.contains("<figcaption>a goal<"), "{page}");
        assert_eq!((page.matches("<figure>").count(), page.matches("<h2 ").count()), (3, 2), "{page}");
    }

    #[test]
    fn a_shooting_report_begins_with_its_score_and_interval_beside_the_papers() {
        let folder = tempfile::tempdir().expect("a folder");
        let report = report();
        let whole = Evaluation::new("shooting", "a & b", &report, Timing::of(Effort::default(), 1.0));
        write_shooting(folder.path(), "mujoco", &report, &to_json(&whole).expect("JSON")).expect("writes");
        let strip = Strip {
            trial: 2,
            words: "no <contact>".to_owned(),
            picture: paid_plot::Canvas::new(4, 4, [9; 3]),
        };
        write_strips(folder.path(), "mujoco_static", &[strip]).expect("writes");
        write_report(folder.path()).expect("writes");
        let page = fs::read_to_string(folder.path().join(REPORT)).expect("the page");
        // 2 of 4: Wilson's interval is 15.0 to 85.0.
        let headline = "<b>50.0%</b> of 4 shots are goals (95% interval 15.0 to 85.0); accuracy 0.800. The paper's policy: 91.3%, 0.969.";
        assert!(page.contains(headline), "{page}");
        for part in [
            "<td>truth: exact positions of ball and goal (the paper's: ball position, no velocity",
            "<td>2: 0.5 to 0.75 m ahead, 0 to 0 m to the left</td>",
            "<td>4, 2 per position, at a goal 2 m wide and 5 m away</td>",
            "The 1 worst shots",
            "no &lt;contact&gt;",
            "<td>a &amp; b</td>",
            "Command:",
        ] {
            assert!(page.contains(part), "{part}: {page}");
        }
        let title = report.title();
        assert_eq!(
            page.matches(title.split(';').next().expect("a title")).count(),
            2,
            "folded, and in the text"
        );
        assert_eq!(page.matches("<tr class=\"goal\">").count(), 2);
        assert_eq!(page.matches("<tr class=\"miss\">").count(), 2);
        assert!(
            !page.contains("http://")
                || page.matches("http://").count() == page.matches("http://www.w3.org").count()
        );
        assert!(!page.contains("https://"), "nothing is loaded from elsewhere");
    }

    #[test]
    fn a_later_report_has_no_strips_of_an_earlier_one_and_the_papers_places_come_first() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut report = report();
        report.effective = Some(CellScore::of(None, &[&report.trials[0]]));
        let strip =
            Strip { trial: 2, words: "earlier".to_owned(), picture: paid_plot::Canvas::new(4, 4, [9; 3]) };
        write_strips(folder.path(), "mujoco_static", &[strip]).expect("writes");
        let whole = Evaluation::new("shooting", "it", &report, Timing::of(Effort::default(), 1.0));
        write_shooting(folder.path(), "mujoco", &report, &to_json(&whole).expect("JSON")).expect("writes");
        write_report(folder.path()).expect("writes");
        let page = fs::read_to_string(folder.path().join(REPORT)).expect("the page");
        assert!(!page.contains("earlier") && !page.contains("worst shots"), "{page}");
        let headline = "<b>100.0%</b> of 1 shots from the effective workspace are goals";
        assert!(page.contains(headline), "{page}");
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = write_report(Path::new("/no/such/folder")).expect_err("missing").to_string();
        assert!(error.contains("/no/such/folder"), "{error}");
    }
}
