//! The vendor's checksum.

/// CRC-32 with polynomial 0x04C11DB7 and initial value 0xFFFFFFFF over little-endian 32-bit words, most significant bit first, not
/// inverted at the end. Bytes beyond the last whole word do not count.
///
/// ```
/// assert_eq!(paid_runtime::wire::crc32(&0x1234_5678_u32.to_le_bytes()), 0xDF8A_8A2B);
/// ```
pub fn crc32(bytes: &[u8]) -> u32 {
    const TABLE: [u32; 256] = table();
    let mut crc = u32::MAX;
    for word in bytes.chunks_exact(4) {
        for &byte in word.iter().rev() {
            crc = crc << 8 ^ TABLE[usize::from((crc >> 24) as u8 ^ byte)];
        }
    }
    crc
}

const fn table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 {
        let mut crc = (i as u32) << 24;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc >> 31 == 1 { crc << 1 ^ 0x04C1_1DB7 } else { crc << 1 };
            bit += 1;
        }
        table[i] = crc;
        i += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_answers() {
        assert_eq!(crc32(&[0; 1000]), 0xFE17_2F9F);
        assert_eq!(crc32(&0x1234_5678_u32.to_le_bytes()), 0xDF8A_8A2B);
        assert_eq!(crc32(&[]), u32::MAX);
    }

    #[test]
    fn every_bit_counts() {
        let good = [0x5A_u8; 64];
        for bit in 0..512 {
            let mut bad = good;
            bad[bit / 8] ^= 1 << (bit % 8);
            assert_ne!(crc32(&bad), crc32(&good), "bit {bit}");
        }
    }
}
