//! README.md and README.zh-CN.md are short, and say the same: commands, code, figures and links.

use std::fs;
use std::path::{Path, PathBuf};

const PAGES: [&str; 2] = ["README.md", "README.zh-CN.md"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(page: &str) -> String {
    fs::read_to_string(root().join(page)).unwrap_or_else(|error| panic!("{page}: {error}"))
}

/// What both pages have in common.
#[derive(Default)]
struct Parts {
    /// Fenced blocks with their first line, in order.
    blocks: Vec<String>,
    /// Code in a line of text.
    commands: Vec<String>,
    /// Targets of links and pictures.
    links: Vec<String>,
    /// Numbers in the text.
    figures: Vec<String>,
}

/// Takes what stands between `start` and `end` out of `text`.
fn take(text: &str, start: &str, end: &str, found: &mut Vec<String>) -> String {
    let (mut rest, mut left) = (String::new(), text);
    while let Some((before, after)) = left.split_once(start) {
        let Some((inside, after)) = after.split_once(end) else { panic!("{start} is not closed: {after}") };
        found.push(inside.to_owned());
        rest.push_str(before);
        rest.push(' ');
        left = after;
    }
    rest + left
}

/// Numbers with their decimals, and a percent sign.
fn figures(text: &str) -> Vec<String> {
    let mut figures = Vec::new();
    let mut figure = String::new();
    let chars: Vec<char> = text.chars().chain([' ']).collect();
    for (i, c) in chars.iter().enumerate() {
        let inside = matches!(c, '.' | ',') && chars.get(i + 1).is_some_and(char::is_ascii_digit);
        if c.is_ascii_digit() || (!figure.is_empty() && inside) {
            figure.push(*c);
        } else if !figure.is_empty() {
            if *c == '%' {
                figure.push('%');
            }
            figures.push(std::mem::take(&mut figure));
        }
    }
    figures
}

/// All but the blocks sorted: word order differs between languages.
fn parts(text: &str) -> Parts {
    let mut parts = Parts::default();
    let text = take(text, "```", "```", &mut parts.blocks);
    let text = take(&text, "<code>", "</code>", &mut parts.commands);
    let text = take(&text, "`", "`", &mut parts.commands);
    let text = take(&text, "href=\"", "\"", &mut parts.links);
    let text = take(&text, "src=\"", "\"", &mut parts.links);
    let text = take(&text, "](", ")", &mut parts.links);
    parts.figures = figures(&text);
    // Each page names the other.
    parts.links.retain(|link| !PAGES.contains(&link.as_str()));
    for list in [&mut parts.commands, &mut parts.links, &mut parts.figures] {
        list.sort();
    }
    parts
}

#[test]
fn both_readmes_say_the_same() {
    let [english, chinese] = PAGES.map(|page| parts(&read(page)));
    assert_eq!(english.blocks, chinese.blocks, "blocks of code");
    assert_eq!(english.commands, chinese.commands, "commands in the text");
    assert_eq!(english.links, chinese.links, "links and pictures");
    assert_eq!(english.figures, chinese.figures, "figures in the text");
    assert!(english.commands.len() > 10 && english.links.len() > 15 && english.figures.len() > 20);
}

#[test]
fn both_readmes_are_short() {
    for page in PAGES {
        let text = read(page);
        let (lines, words) = (text.lines().count(), text.split_whitespace().count());
        assert!(lines <= 90, "{page}: {lines} lines, expected at most 90");
        assert!(words <= 700, "{page}: {words} words, expected at most 700");
    }
}

#[test]
fn every_link_leads_to_a_file() {
    for page in PAGES {
        for link in parts(&read(page)).links.iter().filter(|l| !l.contains("://")) {
            let file = link.split('#').next().expect("a first part");
            assert!(root().join(file).exists(), "{page}: no file {link}");
        }
    }
}

/// The library's example is an excerpt of one that the compiler tests.
#[test]
fn the_example_is_an_excerpt() {
    let source = fs::read_to_string(root().join("crates/base/physics/src/lib.rs")).expect("the source");
    let mut lines = source.lines().filter_map(|line| line.strip_prefix("//!")).map(str::trim);
    let blocks = parts(&read(PAGES[0])).blocks;
    let example = blocks.iter().find_map(|block| block.strip_prefix("rust\n")).expect("an example");
    for line in example.lines().map(str::trim).filter(|line| !line.is_empty()) {
        assert!(
            lines.any(|l| l == line),
            "crates/base/physics/src/lib.rs does not have, in this order: {line}"
        );
    }
}

#[test]
fn parts_of_a_page_are_found() {
    let found =
        parts("5 of `paid x 7`, 99.5% [a](b.md) 3.17.0, 109,000.\n```sh\ny 8\n```\n<img src=\"c.png\">");
    assert_eq!(found.figures, ["109,000", "3.17.0", "5", "99.5%"]);
    assert_eq!((found.blocks.concat(), found.commands.concat()), ("sh\ny 8\n".into(), "paid x 7".into()));
    assert_eq!(found.links, ["b.md", "c.png"]);
}
