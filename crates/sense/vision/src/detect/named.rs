//! An exporter's metadata of its network in the file: its task, and the names of its classes.

use paid_onnx::OnnxFile;

use super::Kind;
use crate::VisionError;

/// Number of COCO's classes, and of its 'sports ball'.
const COCO: [usize; 2] = [80, 32];
/// Names of a soccer ball, in letters alone.
const BALLS: [&str; 5] = ["ball", "sportsball", "soccerball", "football", "soccer"];
/// Classes that an error lists.
const LISTED: usize = 12;

/// Checks that the metadata of a file with the shapes of `kind` do not contradict that.
///
/// # Errors
/// If it is for another task than detecting boxes, or names another number of classes.
pub(super) fn check(file: &OnnxFile, kind: Kind, names: Option<&[String]>) -> Result<(), VisionError> {
    let wrong = |what: &str, expected: String, found: String| {
        Err(VisionError::value(format!("{}: {what}", file.path().display()), expected, found))
    };
    if let Some(task) = file.metadata("task") {
        // Only Ultralytics writes a task, and its heads are not YOLOX's.
        let expected = match kind {
            Kind::YoloV8 { masks: true, .. } => "segment",
            _ => "detect",
        };
        if task != expected {
            let export = "a model of another task gives no boxes: export a detector";
            return wrong(
                "metadata 'task'",
                format!("'{expected}', by its outputs"),
                format!("{task:?}; {export}"),
            );
        }
        if matches!(kind, Kind::YoloX { .. }) {
            let expected = "the heads of YOLOv8 [1, 4 + classes, cells]".to_owned();
            return wrong("output", expected, "them transposed: export without a transposition".to_owned());
        }
    }
    match names {
        Some(names) if names.len() != kind.classes() => {
            let expected = format!("the names of {} classes, by its outputs", kind.classes());
            let other = "the output holds more than boxes and scores, or less";
            wrong("metadata 'names'", expected, format!("{}; {other}", names.len()))
        }
        _ => Ok(()),
    }
}

/// Which class is the ball: the one that was `given`, else the one that is named so.
///
/// # Errors
/// If there is no such class, or the file does not tell.
pub(super) fn ball(
    file: &OnnxFile,
    kind: Kind,
    names: Option<&[String]>,
    given: Option<usize>,
) -> Result<usize, VisionError> {
    let classes = kind.classes();
    let wrong = |expected: String, found: String| {
        Err(VisionError::value(format!("{}: class", file.path().display()), expected, found))
    };
    if let Some(class) = given {
        if class < classes {
            return Ok(class);
        }
        return wrong(format!("0 to {}", classes - 1), class.to_string());
    }
    let Some(names) = names else {
        return match classes {
            1 => Ok(0),
            n if n == COCO[0] => Ok(COCO[1]),
            n => wrong(
                "the number of the ball's class".to_owned(),
                format!("none, and {n} classes without names"),
            ),
        };
    };
    let letters = |name: &String| name.to_lowercase().replace(|c: char| !c.is_alphanumeric(), "");
    let has_word = |name: &String| {
        let name = name.to_lowercase();
        name.split(|c: char| !c.is_alphanumeric()).any(|word| matches!(word, "ball" | "balls"))
    };
    let all = |fits: &dyn Fn(&String) -> bool| -> Vec<usize> {
        (0..).zip(names).filter(|(_, name)| fits(name)).map(|(class, _)| class).collect()
    };
    let mut balls = all(&|name| BALLS.contains(&letters(name).as_str()));
    if balls.is_empty() {
        balls = all(&has_word);
    }
    if let [class] = balls[..] {
        return Ok(class);
    }
    let listed: Vec<String> =
        (0..LISTED).zip(names).map(|(class, name)| format!("{class} {name:?}")).collect();
    let more = if names.len() > LISTED { ", ..." } else { "" };
    wrong(
        "the number of the ball's class, because the names do not show it".to_owned(),
        format!("none; classes are {}{more}", listed.join(", ")),
    )
}

/// The classes' names, as Ultralytics writes them: a dictionary or a list in Python's notation or JSON's; `None` without.
pub(super) fn names(file: &OnnxFile) -> Option<Vec<String>> {
    let text = file.metadata("names")?;
    let mut names = Vec::new();
    let mut rest = text.chars().peekable();
    while let Some(quote) = rest.next() {
        if !matches!(quote, '\'' | '"') {
            continue;
        }
        let mut name = String::new();
        loop {
            match rest.next()? {
                '\\' => name.push(rest.next()?),
                c if c == quote => break,
                c => name.push(c),
            }
        }
        while rest.next_if(|c| c.is_whitespace()).is_some() {}
        // Before a colon it is a key: the number of the next one.
        if rest.peek() != Some(&':') {
            names.push(name);
        }
    }
    (!names.is_empty()).then_some(names)
}
