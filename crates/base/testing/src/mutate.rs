//! Damages files for tests: the same damage for the same numbers, on every machine.

use paid_lanes::rng::Rng;

/// Words that readers meet rarely and stumble over.
const WORDS: [&[u8]; 12] =
    [b"", b"nan", b"-1", b"1e308", b"99999999999", b"\n", b"{", b"}", b"\xff", b"\0", b":", b"(((((((("];

/// `seed` with one to four places damaged, number `number` of all ways.
#[must_use]
pub fn damaged(seed: &[u8], number: u32) -> Vec<u8> {
    let mut rng = Rng::new(17, number, 0);
    let mut out = seed.to_vec();
    for _ in 0..=rng.below(4) {
        let at = rng.below(out.len().max(1)).min(out.len());
        let end = (at + 1 + rng.below(12)).min(out.len());
        match rng.below(7) {
            0 if at < out.len() => out[at] ^= 1 << rng.below(8),
            1 if at < out.len() => out[at] = rng.below(256) as u8,
            2 => drop(out.drain(at..end)),
            3 => {
                let copy = out[at..end].to_vec();
                out.splice(at..at, copy);
            }
            4 => out.truncate(at),
            5 => {
                let word = WORDS[rng.below(WORDS.len())];
                out.splice(at..end, word.iter().copied());
            }
            _ => {
                // A piece of another place.
                let from = rng.below(out.len().max(1)).min(out.len());
                let piece = out[from..(from + 8).min(out.len())].to_vec();
                out.splice(at..at, piece);
            }
        }
    }
    out
}
