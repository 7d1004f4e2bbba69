//! Numbers in a file that need more memory than there is. The runtime does not check them, and a failed allocation cannot be caught.

use crate::proto::{FLOAT, GraphProto, INT64, TensorProto};

/// Largest factor by which one `Resize` may multiply an image's pixels.
const MOST_SCALE: f32 = 4096.0;
/// Longest side that a `Resize` may have.
const MOST_SIDE: i64 = 16_384;

/// What is oversized in a graph's `Resize`, with what was expected; scales and sizes that are computed are not checked.
pub(crate) fn oversized(graph: &GraphProto) -> Option<String> {
    let resizes =
        graph.node.iter().filter(|node| matches!(node.op_type.as_deref(), Some("Resize" | "Upsample")));
    let constants = resizes.flat_map(|node| node.input.iter().skip(1).map(move |name| (node, name)));
    constants.into_iter().find_map(|(node, name)| {
        let constant = graph.initializer.iter().find(|tensor| tensor.name.as_deref() == Some(name))?;
        let wrong = beyond_reason(constant)?;
        Some(format!("{} '{name}': {wrong}", node.op_type.as_deref().unwrap_or_default()))
    })
}

fn beyond_reason(constant: &TensorProto) -> Option<String> {
    let raw = constant.raw_data.as_deref().unwrap_or_default();
    match constant.data_type {
        Some(FLOAT) => {
            let (words, _) = raw.as_chunks::<4>();
            let scale: f32 = words.iter().map(|word| f32::from_le_bytes(*word).max(1.0)).product();
            let sound = scale.is_finite() && scale <= MOST_SCALE;
            (!sound).then(|| format!("expected a scale of at most {MOST_SCALE} in all, found {scale:e}"))
        }
        Some(INT64) => {
            let (words, _) = raw.as_chunks::<8>();
            let wrong =
                words.iter().map(|word| i64::from_le_bytes(*word)).find(|x| !(0..=MOST_SIDE).contains(x));
            wrong.map(|x| format!("expected a size from 0 to {MOST_SIDE}, found {x}"))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::proto::NodeProto;

    fn resize(constant: TensorProto) -> Option<String> {
        let input = ["x", "", "by"].map(str::to_owned).to_vec();
        let node = NodeProto { input, op_type: Some("Resize".to_owned()), ..NodeProto::default() };
        oversized(&GraphProto { node: vec![node], initializer: vec![constant], ..GraphProto::default() })
    }

    #[test]
    fn a_scale_that_no_memory_holds_is_refused_with_what_was_expected() {
        assert_eq!(resize(TensorProto::float("by", &[4], &[1.0, 1.0, 2.0, 2.0])), None);
        assert_eq!(resize(TensorProto::float("by", &[4], &[1.0, 1.0, 0.5, 0.5])), None);
        assert_eq!(
            resize(TensorProto::float("by", &[4], &[1.0, 1.0, 1e6, 1e6])).as_deref(),
            Some("Resize 'by': expected a scale of at most 4096 in all, found 1e12")
        );
        assert!(resize(TensorProto::float("by", &[1], &[f32::INFINITY])).is_some());
        assert_eq!(resize(TensorProto::int64("by", &[1, 3, 640, 640])), None);
        assert_eq!(
            resize(TensorProto::int64("by", &[1, 3, -1, 640])).as_deref(),
            Some("Resize 'by': expected a size from 0 to 16384, found -1")
        );
    }

    #[test]
    fn other_constants_may_be_large() {
        assert_eq!(resize(TensorProto::float("weight", &[1], &[1e9])), None);
    }
}
