//! Links and paths in the text of the repository lead somewhere: in Markdown, and in the comments of sources, manifests, presets and scripts.
//!
//! What counts as a path: a word that begins with one of [`FOLDERS`] or ends in `.md` or `.rs`, in backticks or in a comment. `*` stands
//! for any part of a name. Sources may be named by the end of their path. Documents that are elsewhere ([`ELSEWHERE`]) may not be cited.

use std::collections::HashMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// A word that begins so is a path from the root of the repository.
const FOLDERS: [&str; 10] = [
    "crates/",
    "configs/",
    "docs/",
    "policies/",
    "examples/",
    "benches/",
    "fuzz/",
    "xtask/",
    ".ci/",
    ".github/",
];
/// Parts of names of documents that are not in the repository.
const ELSEWHERE: [&str; 3] = ["-facts", "-notes", "shared/docs"];
/// Folders of builds and runs.
const IGNORED: [&str; 6] = ["target", "runs", "demo", "node_modules", ".git", "book"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the repository")
}

/// Every file of the repository, from its root.
fn files() -> Vec<PathBuf> {
    let root = root();
    let mut found = Vec::new();
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder").flatten() {
            let path = entry.path();
            let name = entry.file_name().to_string_lossy().into_owned();
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                // `policies/demo` is no run.
                let ignored = IGNORED.contains(&name.as_str()) && (folder == root || name == "target");
                if !ignored {
                    folders.push(path);
                }
            } else {
                found.push(path.strip_prefix(&root).expect("below the root").to_owned());
            }
        }
    }
    found.sort();
    found
}

/// The lines of a page outside of its fenced blocks, with their numbers.
fn prose(text: &str) -> Vec<(usize, &str)> {
    let mut fenced = false;
    let mut lines = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            lines.push((index + 1, line));
        }
    }
    lines
}

/// What stands between single backticks.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

/// The comment of a line, if it has one.
fn comment<'a>(line: &'a str, mark: &str) -> Option<&'a str> {
    let trimmed = line.trim_start();
    if trimmed.starts_with(mark) {
        return Some(trimmed);
    }
    let inner = format!(" {mark} ");
    line.find(&inner).map(|at| &line[at..])
}

/// Words of a comment, without the marks around them.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_whitespace() || "`()[]\"';,".contains(c))
        .map(|word| word.trim_end_matches(['.', ':', '?', '!']))
        .filter(|word| !word.is_empty())
}

/// The path that a word names, without line number and anchor; `None`: it is no path, or a placeholder.
fn path_of(word: &str) -> Option<&str> {
    let word = word.split(['#', ':']).next()?;
    let placeholder = word.contains(['<', '>', '{', '}', '$', '|', '=', '…', ' ']) || word.contains("//");
    // `docs/`, `policies/*/scores/` and `README.md` are paths, `*.md` is a kind of file.
    let is_file = [".md", ".rs"].iter().any(|end| word.ends_with(end)) && !word.starts_with(['*', '.']);
    let is_path = FOLDERS.iter().any(|folder| word.starts_with(folder)) || is_file;
    (is_path && !placeholder).then_some(word)
}

/// Whether `pattern`, in which `*` stands for any text, is `name`.
fn matches(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((head, tail)) => name.strip_prefix(head).is_some_and(|rest| {
            (0..=rest.len()).any(|n| rest.is_char_boundary(n) && matches(tail, &rest[n..]))
        }),
    }
}

/// Whether a path with `*` exists below `folder`.
fn exists(folder: &Path, path: &str) -> bool {
    let mut here = vec![folder.to_owned()];
    for part in path.split('/').filter(|part| !part.is_empty()) {
        here = if part.contains('*') {
            here.iter()
                .filter_map(|folder| fs::read_dir(folder).ok())
                .flat_map(|entries| entries.flatten())
                .filter(|entry| matches(part, &entry.file_name().to_string_lossy()))
                .map(|entry| entry.path())
                .collect()
        } else {
            here.into_iter().map(|folder| folder.join(part)).filter(|path| path.exists()).collect()
        };
    }
    !here.is_empty()
}

/// A page's name of a heading, as GitHub and mdBook make it.
fn anchor(heading: &str) -> String {
    heading
        .to_lowercase()
        .chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

fn anchors(text: &str) -> Vec<String> {
    let mut seen: HashMap<String, usize> = HashMap::new();
    let headings = prose(text).into_iter().filter_map(|(_, line)| {
        let heading = line.trim_start_matches('#');
        (heading.len() < line.len() && heading.starts_with(' ')).then(|| anchor(heading.trim()))
    });
    headings
        .map(|name| {
            let times = seen.entry(name.clone()).or_default();
            *times += 1;
            if *times == 1 { name } else { format!("{name}-{}", *times - 1) }
        })
        .collect()
}

/// `a/b/../c` as `a/c`; links may go through folders that a branch does not have.
fn normal(path: &Path) -> PathBuf {
    let mut parts: Vec<Component<'_>> = Vec::new();
    for part in path.components() {
        match (part, parts.last()) {
            (Component::CurDir, _) => {}
            (Component::ParentDir, Some(Component::Normal(_))) => drop(parts.pop()),
            _ => parts.push(part),
        }
    }
    parts.iter().collect()
}

/// What is wrong with the link `target` on the page `page`.
fn wrong_link(page: &Path, target: &str) -> Option<String> {
    let elsewhere = ["http:", "https:", "mailto:"].iter().any(|scheme| target.starts_with(scheme));
    if elsewhere || target.is_empty() {
        return None;
    }
    let (path, heading) = target.split_once('#').unwrap_or((target, ""));
    let folder = page.parent().unwrap_or(Path::new(""));
    let file = if path.is_empty() { page.to_owned() } else { normal(&folder.join(path)) };
    let full = root().join(&file);
    if !full.exists() {
        return Some(format!("no such file: {target}"));
    }
    let is_page = file.extension().is_some_and(|extension| extension == "md");
    if !heading.is_empty() && is_page {
        let text = fs::read_to_string(full).expect("a page");
        if !anchors(&text).iter().any(|name| name == heading) {
            return Some(format!("no such heading: {target}"));
        }
    }
    None
}

/// The repository's files, for paths that a text names.
struct Repository(Vec<PathBuf>);

impl Repository {
    /// Whether `path` stands for a file or folder: from the root, from the folder of the file that names it, or from a folder above that. A
    /// source may be named by the end of its path, with the name of its crate instead of its folder (`paid-train/src/written.rs`).
    fn has(&self, from: &Path, path: &str) -> bool {
        let root = root();
        let end = path.strip_prefix("paid-").unwrap_or(path);
        from.ancestors().skip(1).any(|folder| exists(&root.join(folder), path))
            || (path.ends_with(".rs") && self.0.iter().any(|file| file.ends_with(end)))
    }
}

fn cites_elsewhere(line: &str) -> Option<String> {
    let cited = words(line).find(|word| ELSEWHERE.iter().any(|part| word.contains(part)))?;
    Some(format!("cites a document that is not in the repository: {cited}"))
}

fn in_page(repository: &Repository, page: &Path, text: &str) -> Vec<(usize, String)> {
    let mut wrong = Vec::new();
    for (number, line) in prose(text) {
        let between =
            |begin, end| line.split(begin).skip(1).filter_map(move |rest: &str| rest.split(end).next());
        let links = between("](", ')').chain(between("src=\"", '"'));
        wrong.extend(links.filter_map(|target| wrong_link(page, target)).map(|what| (number, what)));
        let paths = quoted(line).filter_map(path_of).filter(|path| !repository.has(page, path));
        wrong.extend(paths.map(|path| (number, format!("no such path: {path}"))));
        wrong.extend(cites_elsewhere(line).map(|what| (number, what)));
    }
    wrong
}

fn in_comments(repository: &Repository, file: &Path, text: &str, mark: &str) -> Vec<(usize, String)> {
    let mut wrong = Vec::new();
    let comments = text.lines().enumerate().filter_map(|(i, line)| Some((i + 1, comment(line, mark)?)));
    for (number, comment) in comments {
        let paths = words(comment).filter_map(path_of).filter(|path| !repository.has(file, path));
        wrong.extend(paths.map(|path| (number, format!("no such path: {path}"))));
        wrong.extend(cites_elsewhere(comment).map(|what| (number, what)));
    }
    wrong
}

#[test]
fn links_and_paths_in_text_and_comments_lead_somewhere() {
    let mut wrong = Vec::new();
    let mut looked_at = 0;
    let repository = Repository(files());
    for file in &repository.0 {
        let extension = file.extension().unwrap_or_default().to_string_lossy().into_owned();
        let script = extension.is_empty() && file.starts_with(".ci");
        let look: &dyn Fn(&str) -> Vec<(usize, String)> = match extension.as_str() {
            "md" => &|text| in_page(&repository, file, text),
            "rs" => &|text| in_comments(&repository, file, text, "//"),
            "toml" | "yml" | "py" => &|text| in_comments(&repository, file, text, "#"),
            _ if script => &|text| in_comments(&repository, file, text, "#"),
            _ => continue,
        };
        // This file names what it forbids.
        if file.ends_with("xtask/tests/references.rs") {
            continue;
        }
        let text = fs::read_to_string(root().join(file)).expect("text");
        looked_at += 1;
        wrong
            .extend(look(&text).into_iter().map(|(line, what)| format!("{}:{line}: {what}", file.display())));
    }
    assert!(looked_at > 100, "only {looked_at} files");
    assert!(wrong.is_empty(), "{} dangling references:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_dangling_reference_is_found() {
    let repository = Repository(files());
    let page = Path::new("docs/src/start.md");
    let text = "# Page\n[a](nowhere.md) [b](start.md#no-such-part) `docs/none.md`\n<img src=\"none.png\"> [c](#page) see release-facts\n";
    let wrong: Vec<_> = in_page(&repository, page, text).into_iter().map(|(line, _)| line).collect();
    assert_eq!(wrong, [2, 2, 2, 3, 3, 3]); // `#page` is none of start.md's headings
    let code = "let a = 1; // as crates/none says\n/// `configs/presets/*.toml`, README.md, src/main.rs\n// no/such/name.rs\nlet docs = \"docs/none\";\n";
    let wrong: Vec<_> = in_comments(&repository, Path::new("xtask/src/main.rs"), code, "//")
        .into_iter()
        .map(|w| w.0)
        .collect();
    assert_eq!(wrong, [1, 3]);
}

#[test]
fn anchors_are_those_of_github() {
    let text = "# A `code`, and more\n## Twice\n```sh\n# a comment\n```\n## Twice\n";
    assert_eq!(anchors(text), ["a-code-and-more", "twice", "twice-1"]);
}
