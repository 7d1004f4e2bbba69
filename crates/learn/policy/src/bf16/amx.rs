//! AMX tiles: `TDPBF16PS` adds the products of 16 rows, 16 columns and 32 inner numbers at once.
//!
//! The instructions are written as assembly, because their intrinsics are not stable. Tiles 0 to 2 hold 16 rows by 48 columns of
//! sums, tile 3 the left operand, tile 4 the right one.
#![allow(unsafe_code)]

use core::arch::asm;
use core::arch::x86_64::__cpuid_count;
use std::sync::OnceLock;

use super::{Kernel, PAIR_STEP, PANEL, Panels, ROW_STEP, Rows, avx512};
use crate::matrix::{Mat, MatMut};

/// Columns of a tile of sums.
const TILE: usize = 16;
/// Bytes of a row of any tile here.
const ROW_BYTES: usize = 64;

/// True if processor and operating system have tiles and a product of known result comes out right. Asks the kernel for the
/// permission to use tiles, once.
pub(super) fn available() -> bool {
    static AVAILABLE: OnceLock<bool> = OnceLock::new();
    *AVAILABLE.get_or_init(|| processor_has_tiles() && avx512::available() && permitted() && adds_up())
}

/// CPUID leaf 7: AMX-TILE and AMX-BF16.
fn processor_has_tiles() -> bool {
    if __cpuid_count(0, 0).eax < 7 {
        return false;
    }
    let found = __cpuid_count(7, 0).edx;
    found >> 22 & 1 == 1 && found >> 24 & 1 == 1
}

/// Asks Linux for the tile registers (`arch_prctl(ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA)`): the first tile instruction without the
/// permission is fatal. It holds for all threads of the process.
#[cfg(target_os = "linux")]
fn permitted() -> bool {
    const ARCH_PRCTL: i64 = 158;
    const ARCH_REQ_XCOMP_PERM: i64 = 0x1023;
    const XFEATURE_XTILEDATA: i64 = 18;
    let result: i64;
    // SAFETY: a system call with two numbers as arguments; it reads and writes no memory of this process.
    unsafe {
        asm!(
            "syscall",
            inlateout("rax") ARCH_PRCTL => result,
            in("rdi") ARCH_REQ_XCOMP_PERM,
            in("rsi") XFEATURE_XTILEDATA,
            lateout("rcx") _,
            lateout("r11") _,
            options(nostack),
        );
    }
    result == 0
}

#[cfg(not(target_os = "linux"))]
fn permitted() -> bool {
    false
}

/// Compares a small product, remainders on all sides, with the plain loops.
fn adds_up() -> bool {
    const SIZE: [usize; 3] = [19, 37, 53];
    let [rows, inner, cols] = SIZE;
    let numbers = |n: usize, by: f32| -> Vec<f32> { (0..n).map(|i| (i as f32 * by).sin()).collect() };
    let (a, b) = (numbers(rows * inner, 0.7), numbers(inner * cols, 0.3));
    let a = Rows::new(Kernel::PORTABLE, Mat::new(&a, rows, inner, inner));
    let b = Panels::new(Kernel::PORTABLE, Mat::new(&b, inner, cols, cols));
    let (mut want, mut found) = (vec![1.0; rows * cols], vec![1.0; rows * cols]);
    Kernel::PORTABLE.multiply(MatMut::new(&mut want, rows, cols, cols), &a, &b, true);
    multiply(MatMut::new(&mut found, rows, cols, cols), &a, &b, true);
    want.iter().zip(&found).all(|(want, found)| (want - found).abs() <= 1e-4)
}

/// The 64 bytes of `LDTILECFG`: palette 1, five tiles of 16 rows of 64 bytes.
#[repr(C, align(64))]
struct TileConfig([u8; 64]);

impl TileConfig {
    const fn new() -> Self {
        let mut bytes = [0; 64];
        bytes[0] = 1;
        let mut tile = 0;
        while tile < 5 {
            bytes[16 + 2 * tile] = ROW_BYTES as u8;
            bytes[48 + tile] = ROW_STEP as u8;
            tile += 1;
        }
        Self(bytes)
    }
}

/// See [`super::Kernel::multiply`], which has compared the shapes.
pub(super) fn multiply(mut dst: MatMut<'_, f32>, a: &Rows, b: &Panels, accumulate: bool) {
    static CONFIG: TileConfig = TileConfig::new();
    let steps = a.stride() / PAIR_STEP;
    if steps == 0 {
        return super::portable::multiply(dst, a, b, accumulate);
    }
    // SAFETY: reached only where `available()` has found tiles and the permission. `CONFIG` has 64 bytes.
    unsafe { asm!("ldtilecfg [{}]", in(reg) &raw const CONFIG.0, options(nostack, readonly)) };
    let mut sums = [0.0_f32; ROW_STEP * PANEL];
    for first_col in (0..dst.cols()).step_by(PANEL) {
        let panel = b.panel(first_col / PANEL);
        let cols = PANEL.min(dst.cols() - first_col);
        for first_row in (0..a.rows()).step_by(ROW_STEP) {
            let words = &a.words()[first_row * a.stride()..];
            block(words, a.stride(), panel, steps, &mut sums);
            for (r, sums) in sums.chunks_exact(PANEL).take(a.rows() - first_row).enumerate() {
                let row = &mut dst.row(first_row + r)[first_col..first_col + cols];
                for (x, sum) in row.iter_mut().zip(sums) {
                    *x = if accumulate { *x + sum } else { *sum };
                }
            }
        }
    }
    // SAFETY: gives back the tiles that were configured above.
    unsafe { asm!("tilerelease", options(nostack, nomem)) };
}

/// Sums of 16 rows by 48 columns over `steps` times 16 pairs. The tiles must be configured.
fn block(words: &[u32], stride: usize, panel: &[u32], steps: usize, sums: &mut [f32; ROW_STEP * PANEL]) {
    const WORD: usize = size_of::<u32>();
    assert!(steps > 0 && words.len() >= ROW_STEP * stride && stride >= steps * PAIR_STEP);
    assert!(panel.len() >= steps * PAIR_STEP * PANEL && PANEL == 3 * TILE);
    // SAFETY: step k reads 16 rows of 64 bytes of `words`, `stride` words apart, from word 16 k on: below `16 stride`; and 16 rows
    // of 192 bytes of `panel` from row 16 k on. The stores write 16 rows of 3 x 64 bytes, all of `sums`. The flags and all tiles are
    // given as changed.
    unsafe {
        asm!(
            "tilezero tmm0",
            "tilezero tmm1",
            "tilezero tmm2",
            "2:",
            "tileloadd tmm3, [{a} + {a_step}*1]",
            "tileloadd tmm4, [{b} + {b_step}*1]",
            "tdpbf16ps tmm0, tmm3, tmm4",
            "tileloadd tmm4, [{b} + {b_step}*1 + 64]",
            "tdpbf16ps tmm1, tmm3, tmm4",
            "tileloadd tmm4, [{b} + {b_step}*1 + 128]",
            "tdpbf16ps tmm2, tmm3, tmm4",
            "add {a}, 64",
            "add {b}, {b_block}",
            "dec {steps}",
            "jnz 2b",
            "tilestored [{c} + {b_step}*1], tmm0",
            "tilestored [{c} + {b_step}*1 + 64], tmm1",
            "tilestored [{c} + {b_step}*1 + 128], tmm2",
            a = inout(reg) words.as_ptr() => _,
            b = inout(reg) panel.as_ptr() => _,
            c = in(reg) sums.as_mut_ptr(),
            a_step = in(reg) stride * WORD,
            b_step = in(reg) PANEL * WORD,
            b_block = const PAIR_STEP * PANEL * WORD,
            steps = inout(reg) steps => _,
            out("tmm0") _, out("tmm1") _, out("tmm2") _, out("tmm3") _, out("tmm4") _,
            options(nostack),
        );
    }
}
