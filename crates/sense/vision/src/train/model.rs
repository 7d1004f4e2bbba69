//! The network while it is trained: every convolution is followed by batch normalization.

use burn::module::Module;
use burn::nn::conv::{Conv2d, Conv2dConfig};
use burn::nn::{BatchNorm, BatchNormConfig, Initializer, PaddingConfig2d};
use burn::tensor::activation::{log_sigmoid, relu, sigmoid};
use burn::tensor::{Device, Tensor};

use crate::VisionError;
use crate::net::{CHANNELS, Convolution, LAYERS, Layer};

/// A convolution and its normalization; the last one has a bias instead.
#[derive(Module, Debug)]
struct Unit {
    conv: Conv2d,
    norm: Option<BatchNorm>,
}

/// The network of [`crate::net`].
#[derive(Module, Debug)]
pub(super) struct BallNet {
    units: Vec<Unit>,
}

/// The parts of the loss, means over a batch's balls.
pub(super) struct Loss {
    /// What is made small.
    pub total: Tensor<1>,
    /// Part of the heat map.
    pub heat: Tensor<1>,
    /// Part of place and size.
    pub place: Tensor<1>,
}

impl BallNet {
    pub(super) fn new(device: &Device) -> Self {
        let unit = |(layer, inputs, outputs): &(Layer, usize, usize)| {
            let (taps, stride) = (layer.taps(), layer.stride());
            let last = *layer == Layer::Out;
            let pad = taps / 2;
            let initializer = if last {
                Initializer::Normal { mean: 0.0, std: 0.01 }
            } else {
                Initializer::KaimingNormal { gain: 2.0_f64.sqrt(), fan_out_only: false }
            };
            let conv = Conv2dConfig::new([*inputs, *outputs], [taps, taps])
                .with_stride([stride, stride])
                .with_padding(PaddingConfig2d::Explicit(pad, pad, pad, pad))
                .with_bias(last)
                .with_initializer(initializer)
                .init(device);
            Unit {
                conv,
                norm: (!last).then(|| BatchNormConfig::new(*outputs).with_momentum(0.02).init(device)),
            }
        };
        Self { units: LAYERS.iter().map(unit).collect() }
    }

    /// The map `[batch, 5, h / 8, w / 8]` of images `[batch, 4, h, w]`.
    pub(super) fn forward(&self, images: Tensor<4>) -> Tensor<4> {
        let mut x = images;
        let mut fine: Option<Tensor<4>> = None;
        let mut halvings = 0;
        for (unit, (layer, _, _)) in self.units.iter().zip(LAYERS) {
            if layer == Layer::Half {
                halvings += 1;
                if halvings == 4 {
                    fine = Some(x.clone());
                }
            }
            let input = x.clone();
            x = unit.conv.forward(x);
            if let Some(norm) = &unit.norm {
                x = norm.forward(x);
            }
            if layer.relu() {
                x = relu(x);
            }
            match (layer, &fine) {
                (Layer::Residual, _) => x = input + x,
                (Layer::Lateral, Some(fine)) => x = fine.clone() + doubled(x),
                _ => {}
            }
        }
        x
    }

    /// The loss of a batch: `heat` `[batch, 1, h, w]` is the wanted map with 1 at the cells that hold a ball's middle, `care` 0 where the map may
    /// be anything, `place` `[batch, 4, h, w]` the wanted other numbers and `near` where they are wanted.
    ///
    /// The heat map's part is the focal loss of Zhou et al., "Objects as points" (2019), with its exponents 2 and 4; the rest is L1.
    pub(super) fn loss(&self, batch: super::batch::Tensors) -> Loss {
        let out = self.forward(batch.images);
        let logit = out.clone().narrow(1, 0, 1);
        let found = out.narrow(1, 1, CHANNELS - 1);
        let p = sigmoid(logit.clone());
        let one = batch.heat.clone().greater_equal_elem(0.999).float();
        let missed = log_sigmoid(logit.clone()) * (-p.clone() + 1.0).powf_scalar(2.0) * one.clone();
        let doubt = (-batch.heat.clone() + 1.0).powf_scalar(4.0) * batch.care * (-one.clone() + 1.0);
        let invented = log_sigmoid(-logit) * p.powf_scalar(2.0) * doubt;
        let balls = one.sum() + 1.0;
        let heat = -(missed.sum() + invented.sum()) / balls;
        let cells = batch.near.clone().sum() + 1.0;
        let place = ((found - batch.place).abs() * batch.near.repeat_dim(1, CHANNELS - 1)).sum() / cells;
        Loss { total: heat.clone() + place.clone() * 0.5, heat, place }
    }

    /// The weights with the normalization folded in.
    pub(super) fn weights(&self) -> Result<Vec<Convolution>, VisionError> {
        let numbers = |values: burn::tensor::TensorData| {
            values
                .try_to_vec::<f32>()
                .map_err(|e| VisionError::value("trained weights", "32-bit floats", format!("{e:?}")))
        };
        let fold = |(unit, (_, _, outputs)): (&Unit, (Layer, usize, usize))| {
            let mut weight = numbers(unit.conv.weight.val().into_data())?;
            let mut bias = match &unit.conv.bias {
                Some(bias) => numbers(bias.val().into_data())?,
                None => vec![0.0; outputs],
            };
            if let Some(norm) = &unit.norm {
                let gamma = numbers(norm.gamma.val().into_data())?;
                let beta = numbers(norm.beta.val().into_data())?;
                let mean = numbers(norm.running_mean.value_sync().into_data())?;
                let variance = numbers(norm.running_var.value_sync().into_data())?;
                let share = weight.len() / outputs;
                for k in 0..outputs {
                    let scale = gamma[k] / (variance[k] + norm.epsilon as f32).sqrt();
                    for w in &mut weight[k * share..(k + 1) * share] {
                        *w *= scale;
                    }
                    bias[k] = beta[k] + (bias[k] - mean[k]) * scale;
                }
            }
            Ok(Convolution { weight, bias })
        };
        self.units.iter().zip(LAYERS).map(fold).collect()
    }
}

/// Every cell becomes four.
fn doubled(x: Tensor<4>) -> Tensor<4> {
    let [n, c, h, w] = x.dims();
    x.reshape([n * c * h, w, 1]).repeat_dim(2, 2).reshape([n * c, h, 1, 2 * w]).repeat_dim(2, 2).reshape([
        n,
        c,
        2 * h,
        2 * w,
    ])
}

#[cfg(test)]
mod tests {
    use burn::tensor::TensorData;
    use paid_lanes::rng::Rng;
    use paid_onnx::OnnxFile;

    use super::*;
    use crate::detect::Detector;
    use crate::net::{HEIGHT, INPUTS, WIDTH, encode_net};

    #[test]
    fn the_onnx_file_computes_what_the_trained_network_computes() {
        let device = Device::flex();
        device.seed(4);
        let net = BallNet::new(&device);
        let mut rng = Rng::new(3, 0, 0);
        // Statistics as after a training, other than the first ones.
        for norm in net.units.iter().filter_map(|unit| unit.norm.as_ref()) {
            let [channels] = norm.gamma.dims();
            let mut numbers = |low: f64, high: f64| {
                let values: Vec<f32> = (0..channels).map(|_| rng.uniform(low, high) as f32).collect();
                Tensor::<1>::from_data(TensorData::new(values, [channels]), &device)
            };
            norm.running_mean.update(numbers(-0.3, 0.3));
            norm.running_var.update(numbers(0.5, 2.0));
        }
        // First: it takes up the new statistics.
        let bytes = encode_net(&net.weights().expect("floats"), &[]).expect("fits");
        let image: Vec<f32> = (0..INPUTS * WIDTH * HEIGHT).map(|_| rng.unit() as f32).collect();
        let input =
            Tensor::<4>::from_data(TensorData::new(image.clone(), [1, INPUTS, HEIGHT, WIDTH]), &device);
        let expected = net.forward(input).into_data().try_to_vec::<f32>().expect("floats");
        let file = OnnxFile::from_bytes(bytes, "net.onnx".as_ref()).expect("a model");
        let found = Detector::from_file(file, None).expect("runs").run(&image).expect("runs").remove(0);
        assert_eq!(found.len(), expected.len());
        let largest = expected.iter().fold(0.0_f32, |most, v| most.max(v.abs()));
        for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
            assert!((a - b).abs() < 2e-5 * largest.max(1.0), "{i}: {a} {b}");
        }
        assert!(largest > 1e-3, "the network says nothing");
    }
}
