//! Mutations of files.

use rand::RngExt;
use rand_pcg::Pcg64;

/// Numbers that programs stumble over, as text.
const WORDS: [&str; 12] = [
    "1e308",
    "-1e308",
    "1e999",
    "nan",
    "-inf",
    "0",
    "-1",
    "1e-320",
    "18446744073709551616",
    "9007199254740993",
    "2147483648",
    "",
];
/// The same as bytes.
const INTEGERS: [u64; 8] = [0, 1, 0x7f, 0xffff, 0x7fff_ffff, 0xffff_ffff, 0x7fff_ffff_ffff_ffff, u64::MAX];

/// One of the files, changed in one to four ways.
pub fn mutated(files: &[(String, Vec<u8>)], chance: &mut Pcg64) -> Vec<u8> {
    let one = |chance: &mut Pcg64| &files[chance.random_range(0..files.len())].1;
    let mut bytes = one(chance).clone();
    for _ in 0..chance.random_range(1..=4) {
        let at = chance.random_range(0..=bytes.len());
        match chance.random_range(0..8) {
            0 => bytes.truncate(at),
            1 => flip(&mut bytes, at, chance),
            2 => {
                let other = one(chance);
                let from = chance.random_range(0..=other.len());
                bytes.truncate(at);
                bytes.extend_from_slice(&other[from..]);
            }
            3 => {
                let to = (at + chance.random_range(0..200)).min(bytes.len());
                let piece = bytes[at..to].repeat(chance.random_range(1..20));
                bytes.splice(at..at, piece);
            }
            4 => {
                let to = (at + chance.random_range(0..50)).min(bytes.len());
                bytes.drain(at..to);
            }
            5 => {
                let value = INTEGERS[chance.random_range(0..INTEGERS.len())].to_le_bytes();
                let width = [1, 2, 4, 8][chance.random_range(0..4)].min(bytes.len() - at);
                bytes[at..at + width].copy_from_slice(&value[..width]);
            }
            _ => number(&mut bytes, at, chance),
        }
    }
    bytes
}

fn flip(bytes: &mut [u8], at: usize, chance: &mut Pcg64) {
    if let Some(byte) = bytes.get_mut(at) {
        *byte ^= 1 << chance.random_range(0..8);
    }
}

/// Replaces the number in text that begins after `at`, if there is one.
fn number(bytes: &mut Vec<u8>, at: usize, chance: &mut Pcg64) {
    let is_number = |byte: &u8| byte.is_ascii_digit() || b".-+eE".contains(byte);
    let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|start| at + start) else { return };
    let end = bytes[start..].iter().position(|byte| !is_number(byte)).map_or(bytes.len(), |end| start + end);
    let word = WORDS[chance.random_range(0..WORDS.len())];
    bytes.splice(start..end, word.bytes());
}
