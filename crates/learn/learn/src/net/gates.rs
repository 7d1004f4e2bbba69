//! How the gates of recurrent layers are doing: gates that a too large step has shut learn nothing more.

use paid_policy::element::Element;
use paid_policy::net::{Network, Weights};

use super::lstm::{self, LstmCache};
use super::{Sequence, TrainWorkspace};

/// Beyond this share of shut or open, a gate counts as saturated.
const SHUT: f64 = 0.05;

/// The gates of a network's recurrent layers over a sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GateStats {
    /// Share of the input, forget and output gates below 0.05 or above 0.95.
    pub saturated: f64,
    /// Root mean square of the gates' weights, without the biases.
    pub weight_rms: f64,
}

/// The gates of `net` over a sequence; `None` if it has none.
pub fn gate_stats<'w, S: Element>(
    net: &Network,
    weights: impl Into<Weights<'w, S>>,
    sequence: Sequence<'_, S>,
    work: &mut TrainWorkspace<S>,
) -> Option<GateStats> {
    let weights = weights.into();
    let TrainWorkspace { lstm: caches, scratch, .. } = work;
    caches.resize_with(net.lstm.len(), LstmCache::default);
    let (mut saturated, mut gates, mut squares, mut numbers) = (0, 0, 0.0, 0);
    for (k, layer) in net.lstm.iter().enumerate() {
        let (below, here) = caches.split_at_mut(k);
        let x = below.last().map_or(net.remembered(sequence.input), LstmCache::output);
        let start = (&sequence.state.h[k][..], &sequence.state.c[k][..]);
        lstm::forward(layer, weights, x, sequence.steps, start, &mut here[0], scratch);
        let open = here[0].gates();
        for r in (0..2 * layer.size).chain(3 * layer.size..4 * layer.size) {
            saturated += open.row(r).iter().filter(|g| !(SHUT..=1.0 - SHUT).contains(&g.to_f64())).count();
            gates += open.cols();
        }
        for range in [&layer.weight_ih, &layer.weight_hh] {
            squares += weights.values()[range.clone()].iter().map(|w| w.to_f64().powi(2)).sum::<f64>();
            numbers += range.len();
        }
    }
    let share = |part: f64, of: usize| part / of.max(1) as f64;
    net.is_recurrent().then(|| GateStats {
        saturated: share(saturated as f64, gates),
        weight_rms: share(squares, numbers).sqrt(),
    })
}
