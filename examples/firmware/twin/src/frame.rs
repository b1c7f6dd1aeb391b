//! Bytes that a function takes of the stack, read from its instructions (Armv7-M Architecture Reference Manual, chapter A7).
//!
//! `.debug_frame` does not have them: on this target it counts from the frame pointer, and leaves out what lies below.

/// Bytes of stack that a function takes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Frame {
    /// Bytes that it moves the stack pointer down by. It does so once, in front.
    pub bytes: u64,
    /// It calls functions by pointers.
    pub calls_by_pointer: bool,
    /// It moves the stack pointer by a register: how far is not known.
    pub is_unknown: bool,
}

impl Frame {
    /// Looks at more instructions of the function.
    pub fn add(&mut self, code: &[u8]) {
        let mut halves = code
            .chunks_exact(2)
            .map(|half| u32::from(u16::from_le_bytes([half[0], half[1]])));
        while let Some(first) = halves.next() {
            let is_wide = first >> 11 > 0b11100;
            let second = if is_wide {
                halves.next().unwrap_or(0)
            } else {
                0
            };
            self.bytes += u64::from(taken(first, second));
            // ADD SP, Rm, and SUB.W SP, SP, Rm.
            self.is_unknown |= first & 0xff87 == 0x4485 || first == 0xebad && is_sp(second);
            // BLX, BX of another register than the one with the way back, MOV PC.
            let jumps = matches!(first & 0xff87, 0x4780 | 0x4700 | 0x4687);
            self.calls_by_pointer |= jumps && first != 0x4770;
        }
    }
}

/// Whether the second half of an instruction names SP as where its result goes.
const fn is_sp(second: u32) -> bool {
    second & 0x8f00 == 0x0d00
}

/// Bytes that an instruction moves the stack pointer down by.
fn taken(first: u32, second: u32) -> u32 {
    match first {
        // PUSH
        0xb400..=0xb5ff => 4 * (first & 0x1ff).count_ones(),
        // SUB SP, SP, #4 n
        0xb080..=0xb0ff => 4 * (first & 0x7f),
        // PUSH.W of several registers, and of one
        0xe92d => 4 * second.count_ones(),
        0xf84d if second & 0xf00 == 0xd00 => second & 0xff,
        // STRD Rt, Rt2, [SP, #-4 n]!
        0xe96d => 4 * (second & 0xff),
        // VPUSH
        0xed2d | 0xed6d => 4 * (second & 0xff),
        // SUB.W SP, SP, #a constant of eight bits somewhere
        _ if first & 0xfbef == 0xf1ad && is_sp(second) => expanded(constant(first, second)),
        // SUBW SP, SP, #a constant of twelve bits
        _ if first & 0xfbff == 0xf2ad && is_sp(second) => constant(first, second),
        _ => 0,
    }
}

/// The twelve bits of a constant.
const fn constant(first: u32, second: u32) -> u32 {
    (first & 0x400) << 1 | (second & 0x7000) >> 4 | second & 0xff
}

/// `ThumbExpandImm`: what twelve bits stand for.
const fn expanded(bits: u32) -> u32 {
    let byte = bits & 0xff;
    match bits >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => (0x80 | bits & 0x7f).rotate_right(bits >> 7),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(code: &[u16]) -> Frame {
        let bytes: Vec<u8> = code.iter().flat_map(|half| half.to_le_bytes()).collect();
        let mut frame = Frame::default();
        frame.add(&bytes);
        frame
    }

    /// As an assembler writes them: `llvm-mc -triple thumbv7em -show-encoding`.
    #[test]
    fn each_way_to_take_stack_is_counted() {
        for (code, bytes) in [
            (&[0xb5f0][..], 20),                    // push {r4, r5, r6, r7, lr}
            (&[0xb407], 12),                        // push {r0, r1, r2}
            (&[0xe92d, 0x0b00], 12),                // push.w {r8, r9, r11}
            (&[0xf84d, 0xbd04], 4),                 // str r11, [sp, #-4]!
            (&[0xed2d, 0x8b10], 64),                // vpush {d8 .. d15}
            (&[0xb0a2], 136),                       // sub sp, #136
            (&[0xf5ad, 0x6d52], 3360),              // sub.w sp, sp, #3360
            (&[0xf5ad, 0x4d6a], 59_904),            // sub.w sp, sp, #59904
            (&[0xf6ad, 0x5d48], 3400),              // subw sp, sp, #3400
            (&[0xb005, 0xbdf0, 0xf50d, 0x6d52], 0), // add sp, #20; pop; add.w sp, sp, #3360
            (&[0x2000, 0x4770], 0),                 // movs r0, #0; bx lr
        ] {
            let expected = Frame {
                bytes,
                ..Frame::default()
            };
            assert_eq!(frame(code), expected, "{code:x?}");
        }
    }

    #[test]
    fn calls_by_pointer_are_told_from_returns() {
        for (code, expected) in [
            (&[0x4790][..], true),      // blx r2
            (&[0x4708], true),          // bx r1
            (&[0x4770], false),         // bx lr
            (&[0xf000, 0xf800], false), // bl
        ] {
            assert_eq!(frame(code).calls_by_pointer, expected, "{code:x?}");
        }
        assert!(frame(&[0xebad, 0x0d00]).is_unknown); // sub.w sp, sp, r0
    }
}
