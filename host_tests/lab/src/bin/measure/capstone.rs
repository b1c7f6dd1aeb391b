//! The functions of Capstone that `decode.rs` needs.

#![allow(unsafe_code, reason = "a library in C")]

use anyhow::{Result, ensure};
use libloading::Library;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};

// From `capstone.h` of version 5.
const ARCH_ARM: c_int = 0;
/// Thumb, of a Cortex-M.
const MODE: c_int = 1 << 4 | 1 << 5;
const OPTION_DETAIL: c_int = 2;

/// An instruction, as `cs_insn` has it.
#[repr(C)]
struct Instruction {
    id: c_uint,
    address: u64,
    size: u16,
    bytes: [u8; 24],
    mnemonic: [c_char; 32],
    operands: [c_char; 160],
    detail: *mut c_void,
}

/// Numbers of registers, and how many there are.
type Registers = ([u16; 64], u8);

type Open = unsafe extern "C" fn(c_int, c_int, *mut usize) -> c_int;
type Close = unsafe extern "C" fn(*mut usize) -> c_int;
type SetOption = unsafe extern "C" fn(usize, c_int, usize) -> c_int;
type Disassemble =
    unsafe extern "C" fn(usize, *const u8, usize, u64, usize, *mut *mut Instruction) -> usize;
type Free = unsafe extern "C" fn(*mut Instruction, usize);
type Access =
    unsafe extern "C" fn(usize, *const Instruction, *mut u16, *mut u8, *mut u16, *mut u8) -> c_int;
type Name = unsafe extern "C" fn(usize, c_uint) -> *const c_char;

/// A disassembler for Thumb as of a Cortex-M.
#[derive(Debug)]
pub struct Capstone {
    library: &'static Library,
    handle: usize,
}

/// An instruction in words.
#[derive(Debug)]
pub struct Named {
    /// Its bytes.
    pub size: usize,
    /// Its name: `vadd.f32`.
    pub mnemonic: String,
    /// Its operands: `s0, s1, s2`.
    pub operands: String,
    /// Names of the registers that it reads and writes, the flags and the bases of addresses among them.
    pub reads: Vec<String>,
    pub writes: Vec<String>,
}

impl Capstone {
    /// Starts it.
    pub fn new(library: &'static Library) -> Result<Self> {
        let mut handle = 0;
        // SAFETY: the types are those of `capstone.h`, here and below.
        let errors = unsafe {
            let (open, set) = (
                library.get::<Open>(b"cs_open")?,
                library.get::<SetOption>(b"cs_option")?,
            );
            [
                open(ARCH_ARM, MODE, &raw mut handle),
                set(handle, OPTION_DETAIL, 1),
            ]
        };
        ensure!(
            errors == [0; 2],
            "the disassembler does not start: errors {errors:?} of `cs_err`"
        );
        Ok(Self { library, handle })
    }

    /// Instructions of a block, as far as they are known.
    pub fn block(&self, code: &[u8], address: u32) -> Result<Vec<Named>> {
        let mut first = std::ptr::null_mut();
        // SAFETY: it reads the code and makes an array of as many instructions as it returns, which is freed when they were read.
        unsafe {
            let disassemble = self.library.get::<Disassemble>(b"cs_disasm")?;
            let free = self.library.get::<Free>(b"cs_free")?;
            let count = disassemble(
                self.handle,
                code.as_ptr(),
                code.len(),
                address.into(),
                0,
                &raw mut first,
            );
            let named = (0..count).map(|i| self.named(&*first.add(i))).collect();
            if count != 0 {
                free(first, count);
            }
            named
        }
    }

    fn named(&self, instruction: &Instruction) -> Result<Named> {
        let [mut reads, mut writes]: [Registers; 2] = [([0; 64], 0); 2];
        // SAFETY: the arrays have the size of `cs_regs`; texts end with a zero.
        unsafe {
            let access = self.library.get::<Access>(b"cs_regs_access")?;
            let name = self.library.get::<Name>(b"cs_reg_name")?;
            let text = |text: *const c_char| CStr::from_ptr(text).to_string_lossy().into_owned();
            let (r, w) = (&mut reads, &mut writes);
            let error = access(
                self.handle,
                instruction,
                r.0.as_mut_ptr(),
                &raw mut r.1,
                w.0.as_mut_ptr(),
                &raw mut w.1,
            );
            let mnemonic = text(instruction.mnemonic.as_ptr());
            ensure!(error == 0, "{mnemonic}: error {error} of `cs_err`");
            let names = |(registers, count): Registers| {
                let registers = registers.into_iter().take(count.into());
                registers
                    .map(|register| text(name(self.handle, register.into())))
                    .collect()
            };
            Ok(Named {
                size: instruction.size.into(),
                operands: text(instruction.operands.as_ptr()),
                mnemonic,
                reads: names(reads),
                writes: names(writes),
            })
        }
    }
}

impl Drop for Capstone {
    fn drop(&mut self) {
        // SAFETY: it is open, and nobody uses it any more.
        if let Ok(close) = unsafe { self.library.get::<Close>(b"cs_close") } {
            // SAFETY: likewise.
            unsafe { close(&raw mut self.handle) };
        }
    }
}
