//! What stays with its contacts.

use super::*;

/// A log of two files with a contact each; a lag of 2 rows was taken out of the second's.
fn lagging() -> ContactLog {
    let mut log = ContactLog::new(1);
    for name in ["first", "second"] {
        let file = log.add_file(name);
        log.push(&[0.0], 0, Source { file, line: 1 });
    }
    log.set_load_lag(1, 2.0);
    log.set_load_lag(7, 3.0);
    log
}

#[test]
fn the_noise_of_loads_stays_with_their_file() {
    let factors = |log: &ContactLog| -> Vec<f64> { (0..log.len()).map(|i| log.load_noise_factor(i)).collect() };
    assert_eq!(factors(&lagging()), [1.0, 13.0]);
    let mut both = ContactLog::new(1);
    both.append(&lagging(), 0);
    both.append(&lagging(), 1);
    assert_eq!(factors(&both), [1.0, 13.0, 1.0, 13.0]);
    assert_eq!(factors(&both.filtered(|i| i > 0)), [13.0, 1.0, 13.0]);
}
