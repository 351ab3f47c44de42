//! Notes of several logs that say the same.

/// The file that each note begins with, what follows it, and the number of other files of which the
/// same was said.
type Merged = Vec<(Option<String>, String, usize)>;

/// Notes of which those that begin with the names of different `files` and are else the same are
/// said only once, with the first of these files and the number of others.
pub(super) fn merged<'a>(notes: Vec<String>, files: impl Iterator<Item = &'a str> + Clone) -> Vec<String> {
    let split = |note: &str| {
        let of_file = |file: &str| Some((file.to_owned(), note.strip_prefix(file)?.strip_prefix(": ")?.to_owned()));
        files.clone().find_map(of_file)
    };
    let mut merged = Merged::new();
    for note in notes {
        let (file, words) = split(&note).map_or((None, note), |(file, words)| (Some(file), words));
        match merged.iter_mut().find(|(of, known, _)| of.is_some() && file.is_some() && *known == words) {
            Some((_, _, others)) => *others += 1,
            None => merged.push((file, words, 0)),
        }
    }
    let in_words = |(file, words, others): (Option<String>, String, usize)| match (file, others) {
        (None, _) => words,
        (Some(file), 0) => format!("{file}: {words}"),
        (Some(file), 1) => format!("{file} and another log: {words}"),
        (Some(file), _) => format!("{file} and {others} other logs: {words}"),
    };
    merged.into_iter().map(in_words).collect()
}
