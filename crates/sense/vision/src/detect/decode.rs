//! From a network's numbers to boxes.

use super::boxes::Candidate;
use crate::PixelBox;
use crate::net;

/// Boxes of YOLOv8's `output` `[4 + classes (+ coefficients), cells]`: middle and size in pixels of the input, then scores.
pub(super) fn yolo_v8(output: &[f32], cells: usize, class: usize, confidence: f64) -> Vec<Candidate> {
    let row = |k: usize| &output[k * cells..(k + 1) * cells];
    let scores = row(4 + class);
    (0..cells)
        .filter(|&i| f64::from(scores[i]) >= confidence)
        .map(|i| {
            let at = |k: usize| f64::from(row(k)[i]);
            Candidate {
                outline: PixelBox::around([at(0), at(1)], [at(2), at(3)]),
                score: f64::from(scores[i]),
                index: i,
            }
        })
        .collect()
}

/// The cells of the strides 8, 16 and 32, the finest first and row by row: stride `[px]`, column and row.
pub(super) fn grid([width, height]: [usize; 2]) -> impl Iterator<Item = [f64; 3]> {
    [8_usize, 16, 32].into_iter().flat_map(move |stride| {
        (0..height / stride)
            .flat_map(move |y| (0..width / stride).map(move |x| [stride as f64, x as f64, y as f64]))
    })
}

/// The box of a cell's row of YOLOX's output: offset from the cell's corner in cells, logarithm of the size in cells.
pub(super) fn yolo_x_box([stride, x, y]: [f64; 3], row: &[f32]) -> PixelBox {
    let at = |k: usize| f64::from(row[k]);
    PixelBox::around(
        [(at(0) + x) * stride, (at(1) + y) * stride],
        [at(2).exp() * stride, at(3).exp() * stride],
    )
}

/// Boxes of YOLOX's `output` `[cells, 5 + classes]`: the box, whether there is something, and the scores of the classes.
pub(super) fn yolo_x(
    output: &[f32],
    size: [usize; 2],
    classes: usize,
    class: usize,
    confidence: f64,
) -> Vec<Candidate> {
    let rows = output.chunks_exact(5 + classes);
    grid(size)
        .zip(rows)
        .enumerate()
        .filter_map(|(index, (cell, row))| {
            let score = f64::from(row[4]) * f64::from(row[5 + class]);
            (score >= confidence).then(|| Candidate { outline: yolo_x_box(cell, row), score, index })
        })
        .collect()
}

/// Boxes of the project's network's `output` `[5, 24, 40]`: the cells that are hotter than their eight neighbors.
pub(super) fn own(output: &[f32], confidence: f64) -> Vec<Candidate> {
    let (columns, rows) = (net::WIDTH / net::STRIDE, net::HEIGHT / net::STRIDE);
    let plane = columns * rows;
    let heat = &output[..plane];
    let mut found = Vec::new();
    for y in 0..rows {
        for x in 0..columns {
            let i = y * columns + x;
            let score = 1.0 / (1.0 + (-f64::from(heat[i])).exp());
            if score.is_nan() || score < confidence {
                continue;
            }
            let around = (y.saturating_sub(1)..(y + 2).min(rows))
                .flat_map(|v| (x.saturating_sub(1)..(x + 2).min(columns)).map(move |u| v * columns + u));
            // Of two equal neighbors the first one stays.
            let hottest =
                around.clone().all(|j| j == i || heat[j] < heat[i] || (heat[j] == heat[i] && j > i));
            if !hottest {
                continue;
            }
            let at = |k: usize| f64::from(output[k * plane + i]);
            let stride = net::STRIDE as f64;
            // No ball is larger than twice the image or smaller than a pixel.
            let size = [3, 4].map(|k| at(k).clamp(-2.1, 4.4).exp() * stride);
            let middle = [(x as f64 + 0.5 + at(1)) * stride, (y as f64 + 0.5 + at(2)) * stride];
            found.push(Candidate { outline: PixelBox::around(middle, size), score, index: i });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn yolo_v8_gives_middle_and_size_in_pixels() {
        // Two classes, three cells; the second cell has class 1.
        let output = [
            [10.0, 50.0, 30.0],
            [20.0, 60.0, 30.0],
            [4.0, 8.0, 4.0],
            [6.0, 10.0, 4.0],
            [0.9, 0.1, 0.0],
            [0.0, 0.8, 0.2],
        ]
        .concat();
        let found = yolo_v8(&output, 3, 1, 0.25);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].outline.min, found[0].outline.max), ([46.0, 55.0], [54.0, 65.0]));
        assert!((found[0].score - 0.8).abs() < 1e-6 && found[0].index == 1);
    }

    #[test]
    fn yolo_x_counts_cells_from_the_finest_stride() {
        // 64 x 32: 8 x 4 cells of 8 px, then 4 x 2 of 16 px, then 2 x 1 of 32 px.
        let mut output = vec![0.0_f32; (32 + 8 + 2) * 6];
        let mut set = |cell: usize, row: [f32; 6]| output[cell * 6..cell * 6 + 6].copy_from_slice(&row);
        // Cell (3, 1) of stride 8: middle ((0.5 + 3) 8, (0.25 + 1) 8), size (8 e^0, 8 * 2).
        set(8 + 3, [0.5, 0.25, 0.0, std::f32::consts::LN_2, 0.9, 0.8]);
        // Cell (2, 1) of stride 16, too unsure.
        set(32 + 4 + 2, [0.0, 0.0, 0.0, 0.0, 0.5, 0.4]);
        // Cell (1, 0) of stride 32.
        set(40 + 1, [0.0, 0.5, 0.0, 0.0, 1.0, 0.5]);
        let found = yolo_x(&output, [64, 32], 1, 0, 0.25);
        let middles: Vec<[f64; 2]> = found.iter().map(|c| c.outline.middle()).collect();
        assert_eq!(middles, [[28.0, 10.0], [32.0, 16.0]]);
        let size = found[0].outline.size();
        assert!((size[0] - 8.0).abs() < 1e-6 && (size[1] - 16.0).abs() < 1e-5);
        assert!((found[0].score - 0.72).abs() < 1e-6);
    }

    #[test]
    fn the_projects_network_gives_one_box_for_a_ball() {
        let (columns, plane) =
            (net::WIDTH / net::STRIDE, net::WIDTH * net::HEIGHT / net::STRIDE / net::STRIDE);
        let mut output = vec![0.0_f32; net::CHANNELS * plane];
        output[..plane].fill(-9.0);
        let cell = 7 * columns + 11;
        output[cell] = 2.0;
        output[cell + 1] = 1.5;
        output[plane + cell] = 0.25;
        output[2 * plane + cell] = -0.5;
        output[3 * plane + cell] = 3.0_f32.ln();
        output[4 * plane + cell] = 2.0_f32.ln();
        // A number that is none is no ball.
        output[3 * columns] = f32::NAN;
        let found = own(&output, 0.5);
        assert_eq!(found.len(), 1);
        let middle = found[0].outline.middle();
        assert!((middle[0] - 11.75 * 8.0).abs() < 1e-9 && (middle[1] - 7.0 * 8.0).abs() < 1e-9, "{middle:?}");
        let size = found[0].outline.size();
        assert!((size[0] - 24.0).abs() < 1e-5 && (size[1] - 16.0).abs() < 1e-5);
        assert!((found[0].score - 1.0 / (1.0 + (-2.0_f64).exp())).abs() < 1e-9);
    }
}
