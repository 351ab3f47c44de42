//! The import table of ARCHITECTURE.md, executed: a module imports only what its row allows.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

fn crate_dir() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Rows `| module | may import |` of the table under the heading "Import table".
fn table() -> BTreeMap<String, BTreeSet<String>> {
    let text = std::fs::read_to_string(crate_dir().join("../../ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    let section = text.split("## Import table").nth(1).expect("a heading `Import table`");
    let rows = section.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    rows.skip(2)
        .map(|row| {
            let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
            let names = |cell: &str| -> Vec<String> {
                let each = cell.split(',').map(|name| name.trim().trim_matches('`').to_owned());
                each.filter(|name| name != "–").collect()
            };
            (names(cells[0])[0].clone(), names(cells[1]).into_iter().collect())
        })
        .collect()
}

fn rust_files(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            rust_files(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

/// The file's code without comments and without its own tests, which may use anything.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).expect("a readable file");
    let code = text.split("#[cfg(test)]").next().unwrap_or("");
    code.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// The top-level modules named after `crate::`, in lists too.
fn imports(code: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for part in code.split("crate::").skip(1) {
        let list = part.strip_prefix('{').map(|list| list.split('}').next().unwrap_or(""));
        let heads: Vec<&str> = list.map_or_else(|| vec![part], |list| list.split(',').collect());
        for head in heads {
            let name: String = head.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if name.chars().next().is_some_and(char::is_lowercase) {
                found.insert(name);
            }
        }
    }
    found
}

#[test]
fn modules_import_only_what_the_table_allows() {
    let table = table();
    let source = crate_dir().join("src");
    let mut files = Vec::new();
    rust_files(&source, &mut files);
    let mut modules = BTreeSet::new();
    for path in files {
        let relative = path.strip_prefix(&source).expect("below src");
        let first = relative.components().next().expect("a file").as_os_str().to_string_lossy().into_owned();
        let module = first.trim_end_matches(".rs").to_owned();
        if module == "lib" {
            continue;
        }
        let allowed = table.get(&module).unwrap_or_else(|| panic!("module `{module}` has no row in the import table"));
        for import in imports(&code(&path)) {
            assert!(
                import == module || allowed.contains(&import),
                "{}: `{module}` imports `{import}`; the table allows {allowed:?}",
                relative.display()
            );
        }
        modules.insert(module);
    }
    let rows: BTreeSet<String> = table.into_keys().collect();
    assert_eq!(rows, modules, "rows of the table against modules of the crate");
}

#[test]
fn only_io_touches_files_and_nothing_reads_clock_environment_or_chance() {
    let source = crate_dir().join("src");
    let mut files = Vec::new();
    rust_files(&source, &mut files);
    for path in files {
        let text = code(&path);
        let in_io = path.strip_prefix(&source).expect("below src").starts_with("io");
        for banned in
            ["std::time", "std::env", "SystemTime", "Instant::now", "thread_rng", "rand::rng()", "from_os_rng"]
        {
            assert!(!text.contains(banned), "{} uses `{banned}`", path.display());
        }
        assert!(in_io || !text.contains("std::fs"), "{} touches files", path.display());
    }
}

#[test]
fn files_stay_short() {
    let mut files = Vec::new();
    for folder in ["src", "../touchcal-cli/src"] {
        rust_files(&crate_dir().join(folder), &mut files);
    }
    for path in files {
        let lines = std::fs::read_to_string(&path).expect("a readable file").lines().count();
        assert!(lines <= 500, "{} has {lines} lines; split it where it does a second thing", path.display());
    }
}
