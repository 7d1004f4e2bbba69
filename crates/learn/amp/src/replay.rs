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

    /// The place of a random pair; there must be one.
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

    /// Takes back what [`Replay::state`] gave, also that of a smaller ring: there the oldest pair comes first, and new ones after the
    /// newest.
    ///
    /// # Errors
    /// If they do not fit this ring, or cannot have come from one.
    pub fn restore(&mut self, mut pairs: Vec<f32>, next: usize) -> Result<(), String> {
        let (found, width, capacity) = (pairs.len(), self.width, self.capacity);
        let count = found / width;
        if !found.is_multiple_of(width) || count > capacity {
            return Err(format!(
                "replay: expected at most {capacity} pairs of {width} numbers, found {found} numbers"
            ));
        }
        if next > count {
            return Err(format!("replay: expected the next place among {count} pairs, found {next}"));
        }
        self.next = if count < capacity {
            pairs.rotate_left(next * width);
            count
        } else {
            next % capacity
        };
        self.pairs = pairs;
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

    #[test]
    fn a_larger_ring_continues_after_the_newest_pair() {
        let mut small = Replay::new(2, 3);
        let mut large = Replay::new(2, 5);
        let add = |replay: &mut Replay, number: f32| {
            let place = replay.place();
            replay.put(place, &[number, number]);
        };
        let firsts =
            |replay: &Replay| -> Vec<f32> { replay.state().0.chunks_exact(2).map(|pair| pair[0]).collect() };
        (1_u8..=5).for_each(|k| add(&mut small, f32::from(k)));
        large.restore(small.state().0.to_vec(), small.state().1).expect("fits");
        assert_eq!((firsts(&large), large.state().1), (vec![3.0, 4.0, 5.0], 3));
        (6_u8..=8).for_each(|k| add(&mut large, f32::from(k)));
        assert_eq!((firsts(&large), large.state().1), (vec![8.0, 4.0, 5.0, 6.0, 7.0], 1));

        // One that is not full yet stays as it is, and may fill a smaller one.
        let mut young = Replay::new(2, 5);
        (1_u8..=3).for_each(|k| add(&mut young, f32::from(k)));
        let mut other = Replay::new(2, 5);
        other.restore(young.state().0.to_vec(), 3).expect("fits");
        assert_eq!(other, young);
        small.restore(young.state().0.to_vec(), 3).expect("fits");
        assert_eq!((firsts(&small), small.state().1), (vec![1.0, 2.0, 3.0], 0));
    }

    #[test]
    fn a_state_that_no_ring_has_is_refused() {
        let mut replay = Replay::new(2, 3);
        let error = replay.restore(vec![0.0; 4], 3).expect_err("beyond the pairs");
        assert_eq!(error, "replay: expected the next place among 2 pairs, found 3");
        let error = replay.restore(vec![0.0; 3], 0).expect_err("half a pair");
        assert_eq!(error, "replay: expected at most 3 pairs of 2 numbers, found 3 numbers");
        assert!(replay.is_empty() && replay.state().1 == 0, "a refused state changes nothing");
    }
}
