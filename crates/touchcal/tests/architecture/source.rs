//! Source files, and the imports among them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A source file below `src`.
pub struct SourceFile {
    /// Path below `src`: `robot/chain.rs`.
    pub path: String,
    /// Module path below the crate: `["robot", "chain"]`, `["robot"]` for a `mod.rs`.
    pub module: Vec<String>,
    /// Code without comments and without its own tests.
    pub code: String,
}

/// Files with this ending below a folder, sorted.
pub fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a readable folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.to_string_lossy().ends_with(ending) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Code without comments and without its own tests, which may use anything.
pub fn code(text: &str) -> String {
    let code = text.split("#[cfg(test)]").next().unwrap_or("");
    code.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// All files of the library but tests and `lib.rs`.
pub fn library(source: &Path) -> Vec<SourceFile> {
    let mut library = Vec::new();
    for path in files(source, ".rs") {
        let relative = path.strip_prefix(source).expect("below src").to_string_lossy().into_owned();
        let mut module: Vec<String> = relative.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
        if module.last().is_some_and(|last| last == "mod") {
            module.pop();
        }
        // Files of unit tests.
        let is_test = |name: &String| name == "tests" || name == "nist";
        if relative == "lib.rs" || module.last().is_some_and(is_test) {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("a readable file");
        library.push(SourceFile { path: relative, module, code: code(&text) });
    }
    library
}

/// A `use` declaration's paths, lists expanded: `["crate", "robot", "Robot"]`; with whether it is
/// public.
fn use_paths(code: &str) -> Vec<(bool, Vec<String>)> {
    let mut paths = Vec::new();
    let starts = code.match_indices("use ").filter(|(at, _)| {
        let before = code[..*at].trim_end_matches(' ');
        before.is_empty() || before.ends_with(['\n', '{', ';', ')']) || before.ends_with("pub")
    });
    for (at, _) in starts {
        let statement = code[at + 4..].split(';').next().unwrap_or("");
        let line = code[..at].rsplit('\n').next().unwrap_or("");
        expand(statement, &[], &mut |path| paths.push((line.contains("pub"), path)));
    }
    paths
}

/// Expands `a::{b, c::{d, e}}`; renamed items keep their name.
fn expand(tree: &str, prefix: &[String], visit: &mut impl FnMut(Vec<String>)) {
    let tree = tree.trim();
    if let Some((head, rest)) = tree.split_once('{') {
        let mut prefix = prefix.to_vec();
        prefix.extend(head.split("::").map(|part| part.trim().to_owned()).filter(|part| !part.is_empty()));
        let list = rest.trim_end().strip_suffix('}').unwrap_or(rest);
        let (mut depth, mut start) = (0, 0);
        for (k, c) in list.char_indices().chain([(list.len(), ',')]) {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    if !list[start..k].trim().is_empty() {
                        expand(&list[start..k], &prefix, visit);
                    }
                    start = k + 1;
                }
                _ => {}
            }
        }
    } else {
        let name = tree.split(" as ").next().unwrap_or("");
        let parts = name.split("::").map(|part| part.trim().to_owned()).filter(|part| !part.is_empty());
        let path: Vec<String> = prefix.iter().cloned().chain(parts).filter(|part| part != "self").collect();
        visit(path);
    }
}

/// Paths in expressions that start at the crate: `crate::se3::exp`.
fn inline_paths(code: &str) -> Vec<Vec<String>> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let starts = code.match_indices("crate::").map(|(at, _)| at);
    let path = |at: usize| code[at..].chars().take_while(|c| is_name(*c)).collect::<String>();
    starts.map(|at| path(at).split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect()).collect()
}

/// The imports among files, re-exports followed to the defining file.
pub struct ImportGraph {
    /// For each file the files that it imports from.
    pub imports: BTreeMap<String, BTreeSet<String>>,
}

impl ImportGraph {
    pub fn new(library: &[SourceFile]) -> Self {
        let by_module: BTreeMap<&[String], &SourceFile> =
            library.iter().map(|file| (file.module.as_slice(), file)).collect();
        let mut imports = BTreeMap::new();
        for file in library {
            let mut of_file = BTreeSet::new();
            let used = use_paths(&file.code).into_iter().map(|(_, path)| path);
            for path in used.chain(inline_paths(&file.code)) {
                let Some(absolute) = absolute(&path, file, &by_module) else { continue };
                if let Some(target) = resolve(&absolute, &by_module, 0)
                    && target != file.path
                {
                    of_file.insert(target);
                }
            }
            imports.insert(file.path.clone(), of_file);
        }
        ImportGraph { imports }
    }

    /// Groups of files that import each other in a circle.
    pub fn circles(&self) -> Vec<Vec<&str>> {
        let reach = |from: &str| {
            let (mut seen, mut next) = (BTreeSet::new(), vec![from.to_owned()]);
            while let Some(file) = next.pop() {
                for target in self.imports.get(&file).into_iter().flatten() {
                    if seen.insert(target.clone()) {
                        next.push(target.clone());
                    }
                }
            }
            seen
        };
        let reached: BTreeMap<&str, BTreeSet<String>> =
            self.imports.keys().map(|file| (file.as_str(), reach(file))).collect();
        let mut circles: Vec<Vec<&str>> = Vec::new();
        for (&file, reaches) in &reached {
            let together = |other: &&str| reaches.contains(*other) && reached[*other].contains(file);
            let circle: Vec<&str> = self.imports.keys().map(String::as_str).filter(|other| together(other)).collect();
            if !circle.is_empty() && !circles.contains(&circle) {
                circles.push(circle);
            }
        }
        circles
    }
}

/// The path below the crate that a path in a file names; none for other crates.
fn absolute(path: &[String], file: &SourceFile, by_module: &BTreeMap<&[String], &SourceFile>) -> Option<Vec<String>> {
    let first = path.first()?;
    if first == "crate" {
        return Some(path[1..].to_vec());
    }
    let supers = path.iter().take_while(|part| *part == "super").count();
    if supers > 0 {
        let base = file.module.len().checked_sub(supers)?;
        return Some(file.module[..base].iter().chain(&path[supers..]).cloned().collect());
    }
    // A child of this module.
    let child: Vec<String> = file.module.iter().cloned().chain([first.clone()]).collect();
    by_module.contains_key(child.as_slice()).then(|| file.module.iter().chain(path).cloned().collect())
}

/// The file that defines what a path below the crate names.
fn resolve(path: &[String], by_module: &BTreeMap<&[String], &SourceFile>, depth: usize) -> Option<String> {
    let module = (0..=path.len()).rev().find_map(|len| by_module.get(&path[..len]))?;
    let rest = &path[module.module.len()..];
    if let (Some(name), true) = (rest.first(), depth < 8) {
        for (is_public, used) in use_paths(&module.code) {
            if is_public && used.last() == Some(name) {
                let mut target = absolute(&used, module, by_module)?;
                target.extend_from_slice(&rest[1..]);
                return resolve(&target, by_module, depth + 1);
            }
        }
    }
    Some(module.path.clone())
}
