//! Logs of a ball in sockets, and the sockets that their names stand for.
//!
//! | log | socket |
//! |---|---|
//! | `DIR/PLACEMENT/hole_N.csv` | `PLACEMENT/N`; if there are such logs, others in `DIR` are not taken |
//! | `DIR/PLACEMENT/NAME` | `PLACEMENT/N` if the name ends in a number, else `PLACEMENT/NAME` |
//! | `DIR/PLACEMENT_N` | `PLACEMENT/N`, also with `-` or nothing before the number |
//! | `DIR/NAME` | `NAME`, alone at its placement |
//! | `SOCKET=FILE` | `SOCKET` |
//!
//! Logs in a folder end in `.csv`, `.csv.gz`, `.parquet`, `.mcap`, `.log` or `.txt`, or are the
//! folders of ROS 2 bags.

use std::path::{Path, PathBuf};

use crate::io::base::error::{IoError, Place, quoted};
use crate::io::problem::problem_file::placement;

/// Ends of the names of logs.
const ENDS: [&str; 6] = [".csv", ".csv.gz", ".parquet", ".mcap", ".log", ".txt"];
/// File that the folder of a ROS 2 bag has.
const BAG: &str = "metadata.yaml";
/// Most entries of one folder looked at.
pub(super) const MAX_ENTRIES: usize = 10_000;
/// Namings of logs, for messages.
const NAMINGS: &str = "logs of sockets, such as logs/front_0.csv or logs/front/0.csv of socket 0 at placement `front` \
    (.csv, .csv.gz, .parquet, .mcap, .log or .txt, any names, a number at the end for sockets in a row), \
    or each log with its socket, such as front/0=logs/a.csv";

/// A log of a ball in a socket.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SocketLog {
    /// Name of the fixture that the ball touches, such as `front/0`.
    pub socket: String,
    /// The log.
    pub path: PathBuf,
}

impl SocketLog {
    /// Name of the socket's placement: what stands before the first `/` of its name.
    pub fn placement(&self) -> &str {
        placement(&self.socket)
    }

    /// The socket's number at its placement, if it has one: neighbours have successive numbers.
    pub fn number(&self) -> Option<u32> {
        let digits = self.socket.strip_prefix(self.placement())?.strip_prefix('/')?;
        digits.parse().ok().filter(|number: &u32| number.to_string() == digits)
    }
}

/// The logs that each of `names` stands for, sorted by placement, number and name: a folder, a log,
/// or `SOCKET=FILE`. Nothing is read but folders.
///
/// # Errors
/// [`IoError`] with the namings that are accepted if a name is none of these, a folder has no logs,
/// cannot be read or has more than 10 000 entries, or two logs are of one socket.
pub fn find(names: &[PathBuf]) -> Result<Vec<SocketLog>, IoError> {
    let mut logs = Vec::new();
    for name in names {
        logs.extend(of_name(name)?);
    }
    logs.sort_by(|a, b| {
        let key = |log: &SocketLog| (log.placement().to_owned(), log.number(), log.socket.clone());
        key(a).cmp(&key(b))
    });
    match logs.windows(2).find(|pair| pair[0].socket == pair[1].socket) {
        None => Ok(logs),
        Some(pair) => {
            let [first, second] = [&pair[0].path, &pair[1].path].map(|path| path.display());
            let found = format!("{first} and {second} of {}; with names: SOCKET=FILE", quoted(&pair[0].socket));
            Err(IoError::unexpected(Place::file(second.to_string()), "one log of each socket", found))
        }
    }
}

/// Files in the folders among `names` that end like logs and are not among `logs`, which [`find`]
/// found: where logs `hole_N.csv` are in the folders of placements, others are not taken.
///
/// # Errors
/// As [`find`] on folders.
pub fn not_taken(names: &[PathBuf], logs: &[SocketLog]) -> Result<Vec<PathBuf>, IoError> {
    let mut others = Vec::new();
    for folder in names.iter().filter(|name| name.is_dir() && !is_bag(name)) {
        for path in entries(folder)? {
            let within = if path.is_dir() && !is_bag(&path) { entries(&path)? } else { vec![path] };
            others.extend(within.into_iter().filter(|file| stem(file).is_some()));
        }
    }
    others.retain(|file| !logs.iter().any(|log| log.path == *file));
    Ok(others)
}

/// Logs that end in `.txt`, which may be other texts.
pub fn texts(logs: &[SocketLog]) -> impl Iterator<Item = &SocketLog> {
    let is_text = |log: &&SocketLog| log.path.extension().is_some_and(|end| end.eq_ignore_ascii_case("txt"));
    logs.iter().filter(is_text)
}

fn of_name(name: &Path) -> Result<Vec<SocketLog>, IoError> {
    let place = || Place::file(name.display().to_string());
    if name.is_dir() && !is_bag(name) {
        let logs = in_folder(name)?;
        return if logs.is_empty() { Err(IoError::unexpected(place(), NAMINGS, "none")) } else { Ok(logs) };
    }
    if name.exists() {
        let socket = stem(name).map(|stem| of_stem(&stem));
        let socket = socket.ok_or_else(|| IoError::unexpected(place(), NAMINGS, "another name"))?;
        return Ok(vec![SocketLog { socket, path: name.to_owned() }]);
    }
    let Some((socket, file)) = name.to_str().and_then(|name| name.split_once('=')) else {
        return Err(IoError::unexpected(place(), NAMINGS, "no such file or folder"));
    };
    let is_part = |part: &str| !part.is_empty() && !part.chars().any(char::is_control);
    if !socket.split('/').all(is_part) {
        return Err(IoError::unexpected(place(), NAMINGS, format!("the socket {}", quoted(socket))));
    }
    if !Path::new(file).exists() {
        let found = format!("{}, which does not exist", quoted(file));
        return Err(IoError::unexpected(place(), "a log after the socket's name and `=`", found));
    }
    Ok(vec![SocketLog { socket: socket.to_owned(), path: file.into() }])
}

/// The logs in a folder: those of the layout of MUKCa, else all.
fn in_folder(folder: &Path) -> Result<Vec<SocketLog>, IoError> {
    let (mut holes, mut others) = (Vec::new(), Vec::new());
    for path in entries(folder)? {
        if let Some(stem) = stem(&path) {
            others.push(SocketLog { socket: of_stem(&stem), path });
            continue;
        }
        let Some(placement) = path.file_name().and_then(|name| name.to_str()).filter(|_| path.is_dir()) else {
            continue;
        };
        for file in entries(&path)? {
            let log = |within: String| SocketLog { socket: format!("{placement}/{within}"), path: file.clone() };
            if let Some(number) = hole_number(&file) {
                holes.push(log(number.to_string()));
            } else if let Some(stem) = stem(&file) {
                let (_, number) = split_number(&stem);
                others.push(log(number.map_or_else(|| stem.clone(), |number| number.to_string())));
            }
        }
    }
    Ok(if holes.is_empty() { others } else { holes })
}

/// The N of `hole_N.csv`. Written without leading zeros, so that no two files have the same.
pub(super) fn hole_number(path: &Path) -> Option<u32> {
    let digits = path.file_name()?.to_str()?.strip_prefix("hole_")?.strip_suffix(".csv")?;
    let number: u32 = digits.parse().ok()?;
    (number.to_string() == digits).then_some(number)
}

/// The socket of a log that is in no placement's folder.
fn of_stem(stem: &str) -> String {
    match split_number(stem) {
        (placement, Some(number)) if !placement.is_empty() => format!("{placement}/{number}"),
        _ => stem.to_owned(),
    }
}

/// A name without the number at its end and a `_`, `-` or blank before that, and the number.
fn split_number(stem: &str) -> (&str, Option<u32>) {
    let name = stem.trim_end_matches(|letter: char| letter.is_ascii_digit());
    match stem.strip_prefix(name).and_then(|digits| digits.parse().ok()) {
        Some(number) => (name.trim_end_matches(['_', '-', ' ', '.']), Some(number)),
        None => (stem, None),
    }
}

/// The name of a log without its end; of a bag's folder, its name.
fn stem(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    if path.is_dir() {
        return is_bag(path).then(|| name.to_owned());
    }
    let lower = name.to_ascii_lowercase();
    let end = ENDS.iter().filter(|end| lower.ends_with(*end)).max_by_key(|end| end.len())?;
    name.get(..name.len() - end.len()).filter(|stem| !stem.is_empty()).map(str::to_owned)
}

fn is_bag(folder: &Path) -> bool {
    folder.join(BAG).is_file()
}

/// What is in a folder, sorted.
pub(super) fn entries(folder: &Path) -> Result<Vec<PathBuf>, IoError> {
    let failed = |source| IoError::file(folder, "list the folder", source);
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        paths.push(entry.map_err(failed)?.path());
        if paths.len() > MAX_ENTRIES {
            let place = Place::file(folder.display().to_string());
            return Err(IoError::unexpected(place, format!("at most {MAX_ENTRIES} files in a folder"), "more"));
        }
    }
    paths.sort();
    Ok(paths)
}
