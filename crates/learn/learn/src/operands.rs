//! The networks' weights as their products read them.

use paid_policy::bf16::Kernel;
use paid_policy::net::{PackedWeights, Weights};

use crate::model::Model;
use crate::parallel::for_each;

/// Weight matrices of actor and critics in bfloat16; nothing where the products are in f32.
#[derive(Clone, Debug, Default)]
pub struct Operands {
    /// What computes the products; `None`: f32.
    kernel: Option<Kernel>,
    /// The actor's, then the critics'.
    networks: Vec<PackedWeights>,
}

impl Operands {
    /// No weights yet.
    pub fn new(kernel: Option<Kernel>) -> Self {
        Self { kernel, networks: Vec::new() }
    }

    /// `f32`, or the name of a bfloat16 kernel ([`Kernel::name`]).
    pub fn products(&self) -> &'static str {
        self.kernel.map_or("f32", Kernel::name)
    }

    /// Rounds the weights as they are now. Every gradient step must be followed by this before the next product.
    pub fn refresh<'m, W: Send>(&mut self, models: impl Iterator<Item = &'m Model>, workers: &mut [W]) {
        let Some(kernel) = self.kernel else { return };
        let models: Vec<&Model> = models.collect();
        if self.networks.len() == models.len() {
            let items: Vec<_> = self.networks.iter_mut().zip(models).collect();
            for_each(workers, items, |_, (network, model)| network.pack(model.weights()));
        } else {
            let new = |model: &&Model| PackedWeights::new(kernel, &model.net, model.weights());
            self.networks = models.iter().map(new).collect();
        }
    }

    /// Weights of network `k` (0: the actor, then the critics).
    pub fn weights<'a>(&'a self, k: usize, model: &'a Model) -> Weights<'a, f32> {
        Weights::new(model.weights(), self.networks.get(k))
    }
}
