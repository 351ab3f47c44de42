//! Threads of an experiment.

use crate::failure::Failure;

/// Sets the number of threads; as many as cores if not given.
pub fn set(threads: Option<usize>) -> Result<(), Failure> {
    let Some(threads) = threads else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    pool.map_err(|error| Failure::Setup(format!("{threads} threads: {error}")))
}
