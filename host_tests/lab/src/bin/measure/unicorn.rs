//! The functions of Unicorn that `machine.rs` needs.

#![allow(unsafe_code, reason = "a library in C")]

use anyhow::{Result, bail, ensure};
use libloading::Library;
use std::ffi::{c_int, c_void};

// From `unicorn.h` and `arm.h` of version 2.1.
const ARCH_ARM: c_int = 1;
const MODE_THUMB: c_int = 1 << 4;
const HOOK_BLOCK: c_int = 1 << 3;
const HOOK_MEM_READ: c_int = 1 << 10;
/// A new value of one word for the model of the processor.
const SET_CPU_MODEL: c_int = 7 | 1 << 26 | 1 << 30;
/// Models of processors.
pub const CORTEX_M4: c_int = 9;
pub const CORTEX_M7: c_int = 10;
/// What memory may be used for.
pub const READ: u32 = 1;
pub const WRITE: u32 = 2;
pub const EXECUTE: u32 = 4;

/// Registers.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub enum Register {
    Lr = 10,
    Pc = 11,
    Sp = 12,
    R0 = 66,
}

type Handle = *mut c_void;

/// Its functions, as in `unicorn.h`.
#[derive(Debug, Clone, Copy)]
struct Functions {
    open: unsafe extern "C" fn(c_int, c_int, *mut Handle) -> c_int,
    close: unsafe extern "C" fn(Handle) -> c_int,
    ctl: unsafe extern "C" fn(Handle, c_int, ...) -> c_int,
    map: unsafe extern "C" fn(Handle, u64, usize, u32) -> c_int,
    read: unsafe extern "C" fn(Handle, u64, *mut c_void, usize) -> c_int,
    write: unsafe extern "C" fn(Handle, u64, *const c_void, usize) -> c_int,
    register: unsafe extern "C" fn(Handle, c_int, *mut c_void) -> c_int,
    set_register: unsafe extern "C" fn(Handle, c_int, *const c_void) -> c_int,
    hook: unsafe extern "C" fn(
        Handle,
        *mut usize,
        c_int,
        *mut c_void,
        *mut c_void,
        u64,
        u64,
        ...
    ) -> c_int,
    start: unsafe extern "C" fn(Handle, u64, u64, u64, usize) -> c_int,
    stop: unsafe extern "C" fn(Handle) -> c_int,
}

/// A core and its memory.
#[derive(Debug, Clone, Copy)]
pub struct Memory {
    functions: Functions,
    handle: Handle,
}

/// Fails unless a function has succeeded.
fn done(what: &str, error: c_int) -> Result<()> {
    ensure!(
        error == 0,
        "the emulator cannot {what}: error {error} of `uc_err`"
    );
    Ok(())
}

impl Memory {
    /// Maps memory.
    pub fn map(&self, (from, size): (u32, u32), uses: u32) -> Result<()> {
        // SAFETY: the handle is open, here and below.
        let error = unsafe { (self.functions.map)(self.handle, from.into(), size as usize, uses) };
        done("map memory", error)
    }

    /// Reads memory.
    pub fn read(&self, address: u32, length: usize) -> Result<Vec<u8>> {
        let mut bytes = vec![0_u8; length];
        // SAFETY: it writes so many bytes.
        let error = unsafe {
            (self.functions.read)(
                self.handle,
                address.into(),
                bytes.as_mut_ptr().cast(),
                length,
            )
        };
        done(&format!("read {length} bytes at {address:#x}"), error)?;
        Ok(bytes)
    }

    /// Writes memory.
    pub fn write(&self, address: u32, bytes: &[u8]) -> Result<()> {
        let length = bytes.len();
        // SAFETY: it reads so many bytes.
        let error = unsafe {
            (self.functions.write)(self.handle, address.into(), bytes.as_ptr().cast(), length)
        };
        done(&format!("write {length} bytes at {address:#x}"), error)
    }

    /// A register.
    pub fn register(&self, register: Register) -> Result<u32> {
        // Room for what any register holds.
        let mut value = [0_u64; 2];
        // SAFETY: registers of this core have 4 bytes.
        let error = unsafe {
            (self.functions.register)(self.handle, register as c_int, value.as_mut_ptr().cast())
        };
        done("read a register", error)?;
        Ok(value[0] as u32)
    }

    /// Sets a register.
    pub fn set_register(&self, register: Register, value: u32) -> Result<()> {
        let value = [u64::from(value), 0];
        // SAFETY: as above.
        let error = unsafe {
            (self.functions.set_register)(self.handle, register as c_int, value.as_ptr().cast())
        };
        done("write a register", error)
    }

    /// Ends the run, from within a hook.
    pub fn stop(&self) {
        // SAFETY: as above.
        unsafe { (self.functions.stop)(self.handle) };
    }
}

/// Functions that the emulator calls during a run.
pub trait Hooks {
    /// A block of instructions begins.
    fn block(&mut self, memory: &Memory, address: u32, size: u32);
    /// A word is read, which [`Emulator::watch`] was asked for.
    fn read(&mut self, memory: &Memory, address: u32);
}

struct Hooked<H> {
    memory: Memory,
    hooks: H,
}

/// A core that calls hooks.
#[derive(Debug)]
pub struct Emulator<H: Hooks> {
    /// Owned. It stays where it is, because the emulator knows the address.
    hooked: *mut Hooked<H>,
}

unsafe extern "C" fn block<H: Hooks>(_: Handle, address: u64, size: u32, hooked: *mut c_void) {
    // SAFETY: `Emulator::new` has given this pointer. Hooks are called in a run alone, which has the only reference to the emulator.
    let Hooked { memory, hooks } = unsafe { &mut *hooked.cast::<Hooked<H>>() };
    hooks.block(memory, address as u32, size);
}

unsafe extern "C" fn read<H: Hooks>(
    _: Handle,
    _: c_int,
    address: u64,
    _: c_int,
    _: i64,
    hooked: *mut c_void,
) {
    // SAFETY: as above.
    let Hooked { memory, hooks } = unsafe { &mut *hooked.cast::<Hooked<H>>() };
    hooks.read(memory, address as u32);
}

impl<H: Hooks> Emulator<H> {
    /// A Cortex-M without memory.
    pub fn new(library: &'static Library, model: c_int, hooks: H) -> Result<Self> {
        // SAFETY: the types are those of `unicorn.h`.
        let functions = unsafe {
            Functions {
                open: *library.get(b"uc_open")?,
                close: *library.get(b"uc_close")?,
                ctl: *library.get(b"uc_ctl")?,
                map: *library.get(b"uc_mem_map")?,
                read: *library.get(b"uc_mem_read")?,
                write: *library.get(b"uc_mem_write")?,
                register: *library.get(b"uc_reg_read")?,
                set_register: *library.get(b"uc_reg_write")?,
                hook: *library.get(b"uc_hook_add")?,
                start: *library.get(b"uc_emu_start")?,
                stop: *library.get(b"uc_emu_stop")?,
            }
        };
        let mut handle = std::ptr::null_mut();
        // SAFETY: it writes a handle.
        // With the mode of its own, every Cortex-M would be a Cortex-M33, whatever model is asked for.
        done("start", unsafe {
            (functions.open)(ARCH_ARM, MODE_THUMB, &raw mut handle)
        })?;
        let memory = Memory { functions, handle };
        let hooked = Box::into_raw(Box::new(Hooked { memory, hooks }));
        let emulator = Self { hooked };
        // SAFETY: this request has one argument, a word.
        done("be such a core", unsafe {
            (functions.ctl)(handle, SET_CPU_MODEL, model)
        })?;
        // A range that ends before it begins is all of the memory.
        emulator.hook(HOOK_BLOCK, block::<H> as *mut c_void, (1, 0))?;
        Ok(emulator)
    }

    fn hook(&self, kind: c_int, function: *mut c_void, (from, to): (u64, u64)) -> Result<()> {
        let Functions { hook, .. } = self.memory().functions;
        let mut number = 0;
        // SAFETY: the function is one for hooks of this kind.
        let error = unsafe {
            hook(
                self.memory().handle,
                &raw mut number,
                kind,
                function,
                self.hooked.cast(),
                from,
                to,
            )
        };
        done("call hooks", error)
    }

    /// Has [`Hooks::read`] called when the word at this address is read.
    pub fn watch(&self, address: u32) -> Result<()> {
        let from = u64::from(address);
        self.hook(HOOK_MEM_READ, read::<H> as *mut c_void, (from, from + 3))
    }

    /// Its memory and registers.
    pub fn memory(&self) -> &Memory {
        // SAFETY: it lives as long as the emulator, and no hook runs.
        unsafe { &(*self.hooked).memory }
    }

    /// Its hooks.
    pub fn hooks(&self) -> &H {
        // SAFETY: as above.
        unsafe { &(*self.hooked).hooks }
    }

    /// Its hooks, to be changed.
    pub fn hooks_mut(&mut self) -> &mut H {
        // SAFETY: as above, and no other reference is left.
        unsafe { &mut (*self.hooked).hooks }
    }

    /// Runs from one address to another one.
    pub fn run(&mut self, from: u32, to: u32) -> Result<()> {
        let Memory {
            functions, handle, ..
        } = *self.memory();
        // SAFETY: as above.
        let error = unsafe { (functions.start)(handle, from.into(), to.into(), 0, 0) };
        if error != 0 {
            bail!(
                "error {error} of `uc_err` at {:#x}",
                self.memory().register(Register::Pc)?
            );
        }
        Ok(())
    }
}

impl<H: Hooks> Drop for Emulator<H> {
    fn drop(&mut self) {
        // SAFETY: it comes from `new`, and nobody uses it any more.
        let hooked = unsafe { Box::from_raw(self.hooked) };
        // SAFETY: likewise.
        unsafe { (hooked.memory.functions.close)(hooked.memory.handle) };
    }
}
