//! The battery's message: `unitree_hg::msg::dds_::BmsState_`. It has no checksum.

use super::WireError;
use super::walk::{Layout, Message, Walk};

/// The battery's state, some times a second.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BmsState {
    /// Firmware.
    pub version: [u8; 2],
    /// The vendor's.
    pub function: u8,
    /// Voltage of each cell `[mV]`.
    pub cell_vol: [u16; 40],
    /// Voltages of the pack, as the vendor gives them.
    pub voltage: [u32; 3],
    /// Current, as the vendor gives it.
    pub current: i32,
    /// Charge in percent.
    pub soc: u8,
    /// Health in percent.
    pub soh: u8,
    /// Temperatures in degrees Celsius.
    pub temperature: [i16; 12],
    /// Charging cycles.
    pub cycle: u16,
    /// When it was made, as the vendor codes it.
    pub manufacturer_date: u16,
    /// The vendor's bits.
    pub bmsstate: [u32; 5],
    /// Not used.
    pub reserve: [u32; 3],
}

impl Default for BmsState {
    fn default() -> Self {
        Self {
            version: [0; 2],
            function: 0,
            cell_vol: [0; 40],
            voltage: [0; 3],
            current: 0,
            soc: 0,
            soh: 0,
            temperature: [0; 12],
            cycle: 0,
            manufacturer_date: 0,
            bmsstate: [0; 5],
            reserve: [0; 3],
        }
    }
}

impl Message for BmsState {
    const NAME: &'static str = "BmsState_";
    fn walk(&mut self, w: &mut impl Walk) {
        self.version.iter_mut().for_each(|x| w.u8(x));
        w.u8(&mut self.function);
        self.cell_vol.iter_mut().for_each(|x| w.u16(x));
        w.u32s(&mut self.voltage);
        w.i32(&mut self.current);
        w.u8(&mut self.soc);
        w.u8(&mut self.soh);
        self.temperature.iter_mut().for_each(|x| w.i16(x));
        w.u16(&mut self.cycle);
        w.u16(&mut self.manufacturer_date);
        w.u32s(&mut self.bmsstate);
        w.u32s(&mut self.reserve);
    }
}

impl BmsState {
    /// Bytes in CDR, without the header.
    pub const CDR_SIZE: usize = 164;

    /// A battery of which nothing but its charge in percent is known.
    pub fn charged(percent: f64) -> Self {
        Self { soc: percent.clamp(0.0, 100.0).round() as u8, soh: 100, ..Self::default() }
    }
    /// Charge in percent; `None` for what is no percentage.
    pub fn percent(&self) -> Option<f64> {
        (self.soc <= 100).then_some(f64::from(self.soc))
    }
    /// CDR, little-endian, without the header.
    pub fn to_cdr(&self) -> Vec<u8> {
        self.to_bytes(Layout::Cdr)
    }
    /// From [`Self::to_cdr`]'s bytes.
    ///
    /// # Errors
    /// If the length is another.
    pub fn from_cdr(bytes: &[u8]) -> Result<Self, WireError> {
        Self::from_bytes(bytes, Layout::Cdr)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_aligned_to_their_own_size() {
        let mut state = BmsState { soh: 97, cycle: 0x0102, ..BmsState::charged(63.4) };
        state.cell_vol[0] = 0x0A0B;
        state.bmsstate[0] = 0x0708_090A;
        let bytes = state.to_cdr();
        assert_eq!(bytes.len(), BmsState::CDR_SIZE);
        // Three bytes and one of padding, 40 cells, three voltages, the current.
        assert_eq!(bytes[4..6], [0x0B, 0x0A]);
        assert_eq!(bytes[4 + 80 + 12 + 4..][..2], [63, 97]);
        // Twelve temperatures, then the cycles; after the date two bytes of padding.
        assert_eq!(bytes[102 + 24..][..2], [0x02, 0x01]);
        assert_eq!(bytes[132..136], [0x0A, 0x09, 0x08, 0x07]);
        assert_eq!(BmsState::from_cdr(&bytes), Ok(state));
    }

    #[test]
    fn another_length_and_a_charge_that_is_none_are_ignored() {
        assert!(BmsState::from_cdr(&[0; 160]).is_err());
        assert_eq!(BmsState { soc: 101, ..BmsState::default() }.percent(), None);
        assert_eq!(BmsState::charged(19.6).percent(), Some(20.0));
    }
}
