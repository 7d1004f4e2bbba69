//! Pairs of frames of earlier policies.

use paid_lanes::rng::Rng;

/// A ring of pairs: when it is full, new ones take the place of the oldest.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// Numbers of a pair.
    width: usize,
    capacity: usize,
    pairs: Vec<f32>,
    next: usize,
}

impl Replay {
    /// An empty ring of `capacity` pairs of `width` numbers.
    pub fn new(width: usize, capacity: usize) -> Self {
        Self { width, capacity, pairs: Vec::new(), next: 0 }
    }

    /// Number of pairs in it.
    pub fn len(&self) -> usize {
        self.pairs.len() / self.width
    }

    /// True without any pair.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Makes room for a pair; it is for [`Replay::put`] to fill.
    pub fn place(&mut self) -> usize {
        let place = self.next;
        if self.len() < self.capacity {
            self.pairs.resize(self.pairs.len() + self.width, 0.0);
        }
        self.next = (place + 1) % self.capacity;
        place
    }

    /// Writes the pair at a place.
    pub fn put(&mut self, place: usize, pair: &[f32]) {
        self.pairs[place * self.width..][..self.width].copy_from_slice(pair);
    }

    /// The place of a pair by chance; there must be one.
    pub fn draw(&self, rng: &mut Rng) -> usize {
        rng.below(self.len())
    }

    /// The pair at a place.
    pub fn pair(&self, place: usize) -> &[f32] {
        &self.pairs[place * self.width..][..self.width]
    }

    /// Its contents and the place of the next pair, for an exact resume.
    pub fn state(&self) -> (&[f32], usize) {
        (&self.pairs, self.next)
    }

    /// Takes back what [`Replay::state`] gave.
    ///
    /// # Errors
    /// If they do not fit this ring.
    pub fn restore(&mut self, pairs: Vec<f32>, next: usize) -> Result<(), String> {
        if !pairs.len().is_multiple_of(self.width)
            || pairs.len() > self.capacity * self.width
            || next >= self.capacity
        {
            let (found, width, capacity) = (pairs.len(), self.width, self.capacity);
            return Err(format!(
                "replay: expected at most {capacity} pairs of {width} numbers, found {found} numbers"
            ));
        }
        (self.pairs, self.next) = (pairs, next);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_pair_gives_way() {
        let mut replay = Replay::new(2, 3);
        for k in 0..5 {
            let place = replay.place();
            replay.put(place, &[k as f32, -1.0]);
        }
        assert_eq!(replay.len(), 3);
        let firsts: Vec<f32> = replay.state().0.chunks_exact(2).map(|pair| pair[0]).collect();
        assert_eq!(firsts, [3.0, 4.0, 2.0]);
        assert_eq!(replay.state().1, 2, "pair 2 is the next to go");
        assert_eq!(replay.pair(1), [4.0, -1.0]);
        let mut other = Replay::new(2, 3);
        other.restore(replay.state().0.to_vec(), 2).expect("fits");
        assert_eq!(other, replay);
        assert!(other.restore(vec![0.0; 8], 0).is_err());
    }
}
