//! The import table of ARCHITECTURE.md and the rules of CONTRIBUTING.md, executed.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking"
)]

mod source;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use source::{ImportGraph, files, library};

const MAX_FILE_LINES: usize = 400;
const MAX_COMMENT_COLUMNS: usize = 100;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Rows `| module | may import |` of the table under a heading of ARCHITECTURE.md.
fn table(heading: &str) -> BTreeMap<String, BTreeSet<String>> {
    let text = std::fs::read_to_string(repository().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    let section = text.split(&format!("## {heading}")).nth(1).expect("the heading of the table");
    let rows = section.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    let names = |cell: &str| -> Vec<String> {
        let each = cell.split(',').map(|name| name.trim().trim_matches('`').to_owned());
        each.filter(|name| name != "–").collect()
    };
    let mut table = BTreeMap::new();
    for row in rows.skip(2) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let allowed: BTreeSet<String> = names(cells[1]).into_iter().collect();
        for module in names(cells[0]) {
            table.insert(module, allowed.clone());
        }
    }
    table
}

/// The first `depth` folders or files of a path below `src`.
fn room(path: &str, depth: usize) -> String {
    path.trim_end_matches(".rs").trim_end_matches("/mod").split('/').take(depth).collect::<Vec<_>>().join("/")
}

#[test]
fn modules_import_only_what_the_table_allows() {
    let library = library(&source());
    let graph = ImportGraph::new(&library);
    for (heading, within, depth) in
        [("Import table", "", 1), ("Inside `estimate`", "estimate/", 2), ("Inside `io`", "io/", 2)]
    {
        let table = table(heading);
        let mut rooms = BTreeSet::new();
        for (file, imports) in graph.imports.iter().filter(|(file, _)| file.starts_with(within)) {
            let own = room(file, depth);
            if own == within.trim_end_matches('/') {
                continue;
            }
            let name = own.trim_start_matches(within).to_owned();
            let allowed = table.get(&name).unwrap_or_else(|| panic!("`{name}` has no row under {heading}"));
            for import in imports.iter().filter(|import| import.starts_with(within)) {
                let other = room(import, depth);
                let other = other.trim_start_matches(within);
                assert!(
                    other == name || allowed.contains(other),
                    "{file} imports {import}; the table allows `{name}` {allowed:?}"
                );
            }
            rooms.insert(name);
        }
        let rows: BTreeSet<String> = table.into_keys().collect();
        assert_eq!(rows, rooms, "rows of the table under {heading} against the folders");
    }
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    for folder in ["crates/touchcal/src", "crates/touchcal-cli/src", "python/src"] {
        let library = library(&repository().join(folder));
        let graph = ImportGraph::new(&library);
        // A parser that sees nothing would find no circles either.
        assert!(graph.imports.values().map(BTreeSet::len).sum::<usize>() > library.len());
        assert_eq!(graph.circles(), Vec::<Vec<&str>>::new(), "{folder}");
    }
}

#[test]
fn no_type_has_inherent_methods_in_two_files() {
    let mut of_type: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in library(&source()) {
        for line in file.code.lines().filter(|line| line.starts_with("impl") && !line.contains(" for ")) {
            let after = line.trim_start_matches("impl");
            // Skips generic parameters.
            let mut depth = 0;
            let name_at = after.find(|c: char| {
                depth += i32::from(c == '<') - i32::from(c == '>');
                depth == 0 && c.is_alphabetic()
            });
            let name = after[name_at.unwrap_or(0)..].chars().take_while(|c| c.is_alphanumeric() || *c == '_');
            // Types of one name in different modules are different types.
            let name: String = name.collect();
            of_type.entry(name).or_default().insert(file.path.clone());
        }
    }
    for (name, files) in of_type {
        let definitions = library(&source());
        let defines = |text: &str| {
            [format!("struct {name}"), format!("enum {name}"), format!("trait {name}")].iter().any(|definition| {
                text.match_indices(definition.as_str())
                    .any(|(at, found)| !text[at + found.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_'))
            })
        };
        let strangers: Vec<&String> = files
            .iter()
            .filter(|path| definitions.iter().any(|file| &file.path == *path && !defines(&file.code)))
            .collect();
        assert!(strangers.is_empty(), "`{name}` has methods outside of the file that defines it: {strangers:?}");
    }
}

#[test]
fn only_io_touches_files_and_nothing_reads_clock_environment_or_chance() {
    for file in library(&source()) {
        for banned in
            ["std::time", "std::env", "SystemTime", "Instant::now", "thread_rng", "rand::rng()", "from_os_rng"]
        {
            assert!(!file.code.contains(banned), "{} uses `{banned}`", file.path);
        }
        assert!(file.path.starts_with("io/") || !file.code.contains("std::fs"), "{} touches files", file.path);
    }
}

#[test]
fn files_are_short() {
    for folder in ["crates", "python", "fuzz/fuzz_targets", "scripts"] {
        for ending in [".rs", ".py"] {
            for path in files(&repository().join(folder), ending) {
                let lines = std::fs::read_to_string(&path).expect("a readable file").lines().count();
                assert!(lines <= MAX_FILE_LINES, "{} has {lines} lines; split it by ideas", path.display());
            }
        }
    }
}

#[test]
fn comments_are_narrow() {
    for path in files(&repository().join("crates"), ".rs").into_iter().chain(files(&repository().join("python"), ".rs"))
    {
        let text = std::fs::read_to_string(&path).expect("a readable file");
        for (number, line) in text.lines().enumerate().filter(|(_, line)| line.trim_start().starts_with("//")) {
            let (columns, word) = (line.chars().count(), line.split_whitespace().map(|w| w.chars().count()).max());
            // A table row or a word that is longer than the line cannot be broken.
            let is_breakable = !line.contains('|') && word.is_some_and(|word| word < MAX_COMMENT_COLUMNS - 20);
            assert!(
                columns <= MAX_COMMENT_COLUMNS || !is_breakable,
                "{}:{}: a comment of {columns} columns",
                path.display(),
                number + 1
            );
        }
    }
}

/// Whether a line of prose holds the end of one sentence and the start of another.
fn has_two_sentences(line: &str) -> bool {
    let without_code: String = line.split('`').step_by(2).collect::<Vec<_>>().join("`");
    let ends = without_code.match_indices(". ").chain(without_code.match_indices("? "));
    ends.into_iter().any(|(at, _)| {
        let (before, after) =
            (&without_code[..at], without_code[at + 2..].trim_start_matches(['*', '[', '"', '(', '_']));
        let word = before.rsplit([' ', '(']).next().unwrap_or("");
        let is_abbreviation =
            word.len() <= 1 || ["e.g", "i.e", "cf", "et al", "vs", "al", "Eq", "eq", "No"].contains(&word);
        let is_number = word.chars().all(|c| c.is_ascii_digit());
        after.starts_with(char::is_uppercase) && !is_abbreviation && !is_number
    })
}

#[test]
fn markdown_has_one_sentence_a_line() {
    let pages = files(&repository().join("guide"), ".md").into_iter().chain(files(&repository().join("data"), ".md"));
    let top = ["README", "ARCHITECTURE", "DESIGN", "CONTRIBUTING", "CHANGELOG", "VALIDATION"];
    let top = top.map(|name| repository().join(format!("{name}.md")));
    for path in pages.chain(top).filter(|path| !path.ends_with("LICENSE.md")) {
        let text = std::fs::read_to_string(&path).expect("a readable page");
        let mut in_code = false;
        for (number, line) in text.lines().enumerate() {
            in_code ^= line.trim_start().starts_with("```");
            let is_prose = !in_code && !line.starts_with('|');
            let place = format!("{}:{}", path.display(), number + 1);
            assert!(!(is_prose && has_two_sentences(line)), "{place}: two sentences in a line: {line}");
        }
    }
}
