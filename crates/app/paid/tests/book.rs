//! The commands in README, CONTRIBUTING, the book and the policies' pages work.
//!
//! A block marked `sh` is run in a temporary folder, a page after another, with options that make long commands short. A
//! block marked `sh norun` is not run; its subcommands and options must exist. CONTRIBUTING.md says so.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::{SMALL, paid, succeeds};
use paid_mujoco::Library;

/// The repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..").canonicalize().expect("the repository")
}

/// Every page with commands, relative to the repository; those of the book as its summary lists them.
fn pages() -> Vec<PathBuf> {
    let root = root();
    let mut pages: Vec<PathBuf> =
        ["README.md", "CONTRIBUTING.md", "ARCHITECTURE.md", "CHANGELOG.md"].map(PathBuf::from).into();
    let summary = fs::read_to_string(root.join("docs/src/SUMMARY.md")).expect("the summary");
    pages.extend(links(&summary).map(|chapter| Path::new("docs/src").join(chapter)));
    let mut policies: Vec<_> = fs::read_dir(root.join("policies")).expect("policies").flatten().collect();
    policies.sort_by_key(fs::DirEntry::path);
    pages.extend(policies.iter().map(|p| Path::new("policies").join(p.file_name()).join("README.md")));
    pages
}

fn read(page: &Path) -> String {
    fs::read_to_string(root().join(page)).unwrap_or_else(|error| panic!("{}: {error}", page.display()))
}

/// Targets of the links of a page: the text between `](` and `)`.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split(')').next())
}

/// A fenced block: what stands after the fence, its first line's number, its text.
struct Block {
    mark: String,
    line: usize,
    text: String,
}

fn blocks(page: &Path) -> Vec<Block> {
    let text = read(page);
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for (index, line) in text.lines().enumerate() {
        match (line.trim_start().strip_prefix("```"), &mut open) {
            (Some(mark), None) => {
                open = Some(Block { mark: mark.trim().to_owned(), line: index + 2, text: String::new() });
            }
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (None, Some(block)) => block.text += &format!("{line}\n"),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "{}: a block is not closed", page.display());
    blocks
}

/// A command line of a page.
struct Command {
    /// Page and line, for messages.
    place: String,
    words: Vec<String>,
    run: bool,
}

impl Command {
    /// The arguments of `paid`, if that is the program.
    fn paid(&self) -> Option<&[String]> {
        match &self.words[..] {
            [program, args @ ..] if program == "paid" => Some(args),
            [cargo, run, release, dashes, args @ ..]
                if [cargo, run, release, dashes] == ["cargo", "run", "--release", "--"] =>
            {
                Some(args)
            }
            _ => None,
        }
    }
}

/// The words of a line as a shell has them: quotes, and a comment from ` #` on. Anything more is refused.
fn words(line: &str, place: &str) -> Vec<String> {
    let mut words = Vec::new();
    let (mut word, mut quote) = (None::<String>, None::<char>);
    for c in line.chars() {
        match (c, quote) {
            (c, Some(q)) if c == q => quote = None,
            (c, Some(_)) => word.get_or_insert_default().push(c),
            ('\'' | '"', None) => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (' ', None) => words.extend(word.take()),
            ('#', None) if word.is_none() => break,
            ('|' | '>' | '<' | ';' | '&' | '$', None) => panic!("{place}: {c} needs a shell: {line}"),
            (c, None) => word.get_or_insert_default().push(c),
        }
    }
    assert!(quote.is_none(), "{place}: a quote is not closed: {line}");
    words.extend(word);
    words
}

/// The commands of a page's `sh` blocks.
fn commands(page: &Path) -> Vec<Command> {
    let mut commands = Vec::new();
    for block in blocks(page) {
        let run = match &*block.mark {
            "sh" => true,
            "sh norun" => false,
            mark => {
                assert!(!mark.starts_with("sh"), "{}:{}: {mark}", page.display(), block.line - 1);
                continue;
            }
        };
        let text = block.text.replace("\\\n", " ");
        for line in text.lines() {
            let place = format!("{}:{}", page.display(), block.line);
            let words = words(line, &place);
            if !words.is_empty() {
                commands.push(Command { place, words, run });
            }
        }
    }
    commands
}

/// Pages of `--help` by subcommand.
#[derive(Default)]
struct Help(HashMap<Vec<String>, String>);

impl Help {
    fn of(&mut self, subcommand: &[String]) -> &str {
        self.0.entry(subcommand.to_vec()).or_insert_with(|| {
            let args: Vec<&str> = subcommand.iter().map(String::as_str).chain(["--help"]).collect();
            succeeds(&paid(Path::new("."), &args))
        })
    }

    /// Asserts that the subcommand of `args` and its options exist.
    fn knows(&mut self, args: &[String], place: &str) {
        let mut depth = 0;
        while let Some(word) = args.get(depth).filter(|w| !w.starts_with('-')) {
            let help = self.of(&args[..depth]);
            let Some((_, list)) = help.split_once("Commands:\n") else { break };
            let mut names =
                list.lines().take_while(|l| !l.is_empty()).filter_map(|l| l.split_whitespace().next());
            assert!(names.any(|name| name == word), "{place}: no subcommand {word}");
            depth += 1;
        }
        let help = self.of(&args[..depth]);
        for option in args[depth..].iter().filter(|a| a.starts_with("--")) {
            let name = option.split('=').next().expect("a name");
            let mut known = help.split(|c: char| c.is_whitespace() || c == ',');
            assert!(known.any(|w| w == name), "{place}: paid {} has no {name}", args[..depth].join(" "));
        }
    }
}

/// Sets the given ones of these options to 1.
fn least(args: &mut [&str], options: &[&str]) {
    for k in 1..args.len() {
        if options.contains(&args[k - 1]) {
            args[k] = "1";
        }
    }
}

/// Options that make a command short.
fn shortened(args: &[String]) -> Vec<&str> {
    let mut args: Vec<&str> = args.iter().map(String::as_str).collect();
    match &args[..] {
        ["demo", ..] => args.extend(["--trials", "1", "--record", "1"]),
        ["train", rest @ ..] if !rest.contains(&"--explain") => {
            args.extend(["--iterations", "1", "--quiet"]);
            args.extend(SMALL);
        }
        ["eval", "shooting", ..] => {
            least(&mut args, &["--trials"]);
            args.extend(["--limit", "0.5"]);
        }
        ["eval", "robustness" | "terrain", ..] => args.extend(["--limit", "0.04"]),
        ["eval", "match", ..] => least(&mut args, &["--kicks", "--matches"]),
        ["play", rest @ ..] if !rest.contains(&"--size") => {
            args.extend(["--size", "160x120", "--pictures", "5"]);
        }
        ["sysid", first, ..] if first.starts_with('-') => {
            args.extend(["--restarts", "2"]);
        }
        _ => {}
    }
    args
}

#[test]
fn every_command_and_option_in_the_text_exists() {
    let mut help = Help::default();
    let aliases = fs::read_to_string(root().join(".cargo/config.toml")).expect("aliases");
    let mut number = 0;
    for command in pages().iter().flat_map(|page| commands(page)) {
        if let Some(args) = command.paid() {
            help.knows(args, &command.place);
            number += 1;
            continue;
        }
        let words = command.words.iter().skip_while(|w| w.contains('=')).collect::<Vec<_>>();
        match &words[..] {
            [script] if *script == ".ci/run" => {}
            // Its own options, then the program and its arguments.
            [mpirun, rest @ ..] if *mpirun == "mpirun" => {
                let start = rest.iter().position(|w| *w == "paid" || w.ends_with("/paid"));
                let args = &rest[start.expect("mpirun starts paid") + 1..];
                help.knows(&args.iter().map(|w| (*w).clone()).collect::<Vec<_>>(), &command.place);
                number += 1;
            }
            [cargo, name, ..] if *cargo == "cargo" => {
                let known = ["build", "run", "test", "clippy", "fmt"].contains(&name.as_str())
                    || aliases.lines().any(|l| l.split('=').next().is_some_and(|k| k.trim() == *name));
                assert!(known, "{}: no cargo {name}", command.place);
            }
            _ => panic!("{}: an unknown program: {:?}", command.place, command.words),
        }
    }
    assert!(number > 40, "{number} commands of paid");
}

// Slow: runs every command of the book, because readers type them.
#[test]
fn the_commands_in_the_text_run() {
    // Pages are independent of each other, and few commands have work for all cores.
    let (pages, next) = (pages(), AtomicUsize::new(0));
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(4);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(page) = pages.get(next.fetch_add(1, Ordering::Relaxed)) {
                    run_page(page);
                }
            });
        }
    });
}

/// Runs a page's commands in a reader's folder, where the policies and the files that the page shows are.
fn run_page(page: &Path) {
    let test = "the_commands_in_the_text_run";
    let commands = commands(page);
    if !commands.iter().any(|c| c.run && c.paid().is_some()) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    copy(&root().join("policies/demo"), &folder.path().join("policies/demo"));
    for block in blocks(page).iter().filter(|b| b.mark == "toml") {
        let name = block.text.lines().next().and_then(|l| l.strip_prefix("# "));
        if let Some(name) = name.filter(|n| n.ends_with(".toml")) {
            fs::write(folder.path().join(name), &block.text).expect("writes");
        }
    }
    for command in commands.iter().filter(|c| c.run) {
        let Some(args) = command.paid() else { continue };
        if in_mujoco(args) && paid_testing::mujoco(test, Library::get()).is_none() {
            continue;
        }
        let output = paid(folder.path(), &shortened(args));
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {}: {error}", command.place, command.words.join(" "));
    }
}

/// True for a command that runs in MuJoCo: it names the engine, or has no other.
fn in_mujoco(args: &[String]) -> bool {
    let only = ["mujoco", "compare", "drill", "panel", "robustness", "sim", "terrain"];
    args.iter().any(|a| only.contains(&a.as_str()))
}

/// Copies a folder of files.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for file in fs::read_dir(from).expect("a folder").flatten().filter(|f| f.path().is_file()) {
        fs::copy(file.path(), to.join(file.file_name())).expect("copies");
    }
}

#[test]
fn words_are_those_of_a_shell() {
    let found = words("paid eval --set 'a.b=[0.1, 2]'  x  # and so on", "here");
    assert_eq!(found, ["paid", "eval", "--set", "a.b=[0.1, 2]", "x"]);
    assert!(words("# nothing", "here").is_empty());
}

#[test]
#[should_panic(expected = "paid demo has no --nonsense")]
fn an_option_that_does_not_exist_is_found() {
    Help::default().knows(&["demo", "--nonsense"].map(str::to_owned), "here");
}
