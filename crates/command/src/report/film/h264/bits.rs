//! Bits of an H.264 stream: fixed lengths, Exp-Golomb codes (clause 9.1), NAL units with emulation prevention (clause
//! 7.4.1).

/// A sequence of bits.
#[derive(Debug, Default)]
pub(super) struct Bits {
    bytes: Vec<u8>,
    held: u64,
    count: u32,
}

impl Bits {
    /// Appends the lowest `count` bits of a value; `count` is at most 32.
    pub fn put(&mut self, value: u32, count: u32) {
        debug_assert!(count <= 32 && (count == 32 || value >> count == 0));
        self.held = self.held << count | u64::from(value);
        self.count += count;
        while self.count >= 8 {
            self.count -= 8;
            self.bytes.push((self.held >> self.count) as u8);
        }
    }

    /// Appends an unsigned Exp-Golomb code.
    pub fn ue(&mut self, value: u32) {
        let length = 32 - (value + 1).leading_zeros();
        self.put(0, length - 1);
        self.put(value + 1, length);
    }

    /// Appends a signed Exp-Golomb code.
    pub fn se(&mut self, value: i32) {
        let code = if value > 0 { 2 * value - 1 } else { -2 * value };
        self.ue(code.unsigned_abs());
    }

    /// Returns the bits as a NAL unit with a header and a stop bit; emulation prevention avoids byte sequences like the
    /// start code of a unit.
    pub fn unit(mut self, header: u8) -> Vec<u8> {
        self.put(1, 1);
        let fill = (8 - self.count) % 8;
        self.put(0, fill);
        let mut unit = vec![header];
        let mut zeros = 0;
        for byte in self.bytes {
            if zeros == 2 && byte <= 3 {
                unit.push(3);
                zeros = 0;
            }
            zeros = if byte == 0 { zeros + 1 } else { 0 };
            unit.push(byte);
        }
        unit
    }
}
