//! An emulated core that runs one function of a program at a time, and counts.
//!
//! The emulator reports every block of instructions that it runs. A block is decoded once.

use crate::decode::Decoder;
use crate::image::Image;
use crate::timing::Core;
use anyhow::{Context, Result, anyhow, bail};
use std::collections::HashMap;
use unicorn_engine::unicorn_const::{Arch, ArmCpuModel, Mode, Prot};
use unicorn_engine::{RegisterARM, Unicorn};

const FLASH: (u32, u32) = (0x0800_0000, 0x10_0000);
const RAM: (u32, u32) = (0x2000_0000, 0x2_0000);
/// The address that functions return to: the end of flash.
const RETURN: u32 = FLASH.0 + FLASH.1 - 16;
/// Bytes at the start of RAM that are kept for the program's statics; the rest is stack.
const DATA: u32 = 0x1_0000;
/// Paint of the unused stack.
const PAINT: u8 = 0xA5;

/// Counts of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Count {
    /// Instructions.
    pub instructions: u64,
    /// Modelled cycles.
    pub cycles: u64,
}

impl Count {
    /// Without the counts of another run.
    pub fn less(self, other: Self) -> Self {
        Self {
            instructions: self.instructions.saturating_sub(other.instructions),
            cycles: self.cycles.saturating_sub(other.cycles),
        }
    }
}

struct Watch {
    core: Core,
    decoder: Decoder,
    flash: Vec<u8>,
    /// Counts of a block, by address and size.
    blocks: HashMap<(u32, u32), Count>,
    count: Count,
    /// The address behind the last block.
    end: Option<u32>,
    failure: Option<anyhow::Error>,
}

impl Watch {
    fn enter(&mut self, address: u32, size: u32) -> Result<()> {
        let block = match self.blocks.get(&(address, size)) {
            Some(block) => *block,
            None => {
                let from = (address - FLASH.0) as usize;
                let code = self
                    .flash
                    .get(from..from + size as usize)
                    .context("instructions outside of flash")?;
                let instructions = self.decoder.block(code, address)?;
                let block = Count {
                    instructions: instructions.len() as u64,
                    cycles: self.core.cycles(&instructions),
                };
                self.blocks.insert((address, size), block);
                block
            }
        };
        if self.end.is_some_and(|end| end != address) {
            self.count.cycles += self.core.taken();
        }
        self.count.instructions += block.instructions;
        self.count.cycles += block.cycles;
        self.end = Some(address + size);
        Ok(())
    }
}

/// The core, with a program.
pub struct Machine {
    uc: Unicorn<'static, Watch>,
}

impl Machine {
    /// A core with this program in its memory.
    pub fn new(core: Core, image: &Image) -> Result<Self> {
        let mut flash = vec![0; FLASH.1 as usize];
        let mut ram = vec![0; RAM.1 as usize];
        for (address, data) in &image.segments {
            let (memory, start) = if *address >= RAM.0 {
                (&mut ram, RAM.0)
            } else {
                (&mut flash, FLASH.0)
            };
            let from = address.checked_sub(start).map(|from| from as usize);
            from.and_then(|from| memory.get_mut(from..from + data.len()))
                .context("a segment outside of memory")?
                .copy_from_slice(data);
        }
        let watch = Watch {
            core,
            decoder: Decoder::new()?,
            flash: flash.clone(),
            blocks: HashMap::new(),
            count: Count::default(),
            end: None,
            failure: None,
        };
        // With `Mode::MCLASS` every core would be a Cortex-M33, whatever model is asked for.
        let mut uc = Unicorn::new_with_data(Arch::ARM, Mode::THUMB, watch)
            .context("the emulator cannot start")?;
        let model = match core {
            Core::M4f => ArmCpuModel::CORTEX_M4,
            Core::M7 => ArmCpuModel::CORTEX_M7,
        };
        uc.ctl_set_cpu_model(model as i32)
            .context("the emulator cannot be this core")?;
        for ((start, size), data, rights) in [
            (FLASH, &flash, Prot::READ | Prot::EXEC),
            (RAM, &ram, Prot::READ | Prot::WRITE),
        ] {
            uc.mem_map(start.into(), size.into(), rights)
                .context("the emulator cannot map memory")?;
            uc.mem_write(start.into(), data)
                .context("the emulator cannot fill memory")?;
        }
        uc.add_block_hook(1, 0, |uc, address, size| {
            let watch = uc.get_data_mut();
            if watch.failure.is_none()
                && let Err(error) = watch.enter(address as u32, size)
            {
                watch.failure = Some(error);
                let _ = uc.emu_stop();
            }
        })
        .context("the emulator cannot report its blocks")?;
        Ok(Self { uc })
    }

    /// Calls a function; returns its result and the counts.
    pub fn call(&mut self, function: u32) -> Result<(u32, Count)> {
        let watch = self.uc.get_data_mut();
        (watch.count, watch.end) = (Count::default(), None);
        let stack = RAM.0 + RAM.1;
        for (register, value) in [(RegisterARM::SP, stack), (RegisterARM::LR, RETURN | 1)] {
            self.uc
                .reg_write(register, value.into())
                .context("the emulator cannot set a register")?;
        }
        let end = self
            .uc
            .emu_start((function | 1).into(), RETURN.into(), 0, 0);
        if let Some(error) = self.uc.get_data_mut().failure.take() {
            return Err(error);
        }
        let read = |register| {
            self.uc
                .reg_read(register)
                .context("the emulator cannot read a register")
        };
        let at = read(RegisterARM::PC)?;
        end.map_err(|e| anyhow!("the program failed at {at:#x}: {e:?}"))?;
        if at as u32 & !1 != RETURN {
            bail!("the program stopped at {at:#x}");
        }
        Ok((read(RegisterARM::R0)? as u32, self.uc.get_data().count))
    }

    /// Calls a function and tells how many bytes of stack it touched.
    pub fn stack_of(&mut self, function: u32) -> Result<u64> {
        let lowest = RAM.0 + DATA;
        let size = (RAM.1 - DATA) as usize;
        self.write(lowest, &vec![PAINT; size])?;
        self.call(function)?;
        let stack = self.read(lowest, size)?;
        let unused = stack.iter().take_while(|byte| **byte == PAINT).count();
        Ok((size - unused) as u64)
    }

    /// The memory, but for the stack.
    pub fn memory(&self) -> Result<Vec<u8>> {
        self.read(RAM.0, DATA as usize)
    }

    /// Puts the memory back.
    pub fn restore(&mut self, memory: &[u8]) -> Result<()> {
        self.write(RAM.0, memory)
    }

    /// Reads memory.
    pub fn read(&self, address: u32, length: usize) -> Result<Vec<u8>> {
        self.uc
            .mem_read_as_vec(address.into(), length)
            .context("the emulator cannot read memory")
    }

    /// Reads a word.
    pub fn word(&self, address: u32) -> Result<u32> {
        let bytes = self.read(address, 4)?;
        let word = bytes.first_chunk().context("a word has four bytes")?;
        Ok(u32::from_le_bytes(*word))
    }

    /// Writes memory.
    pub fn write(&mut self, address: u32, data: &[u8]) -> Result<()> {
        self.uc
            .mem_write(address.into(), data)
            .context("the emulator cannot write memory")
    }
}
