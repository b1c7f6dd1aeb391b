//! An emulated core that runs one function of a program at a time, and counts.
//!
//! The emulator reports every block of instructions that it runs. A block is decoded once.

use crate::decode::Decoder;
use crate::image::Image;
use crate::timing::Core;
use anyhow::{Context, Result, ensure};
use std::collections::HashMap;
use unicorn_engine::unicorn_const::{Arch, ArmCpuModel, HookType, Mode, Prot};
use unicorn_engine::{RegisterARM, Unicorn};

const FLASH: (u32, u32) = (0x0800_0000, 0x10_0000);
const RAM: (u32, u32) = (0x2000_0000, 0x2_0000);
/// The address that functions return to: the end of flash.
const RETURN: u32 = FLASH.0 + FLASH.1 - 16;
/// The stack, in memory of its own: all of the RAM may be the program's variables.
const STACK: (u32, u32) = (0x1000_0000, 0x1_0000);
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
    /// Counts of a block, by address and size.
    blocks: HashMap<(u32, u32), Count>,
    count: Count,
    /// The address behind the last block.
    end: Option<u32>,
    /// Cycles at each look of the program at the counter, and the address of the instruction that looks.
    looks: Vec<u32>,
    lookers: Vec<u32>,
    failure: Option<anyhow::Error>,
}

/// Counts a block that begins.
fn enter(uc: &mut Unicorn<'_, Watch>, address: u32, size: u32) -> Result<()> {
    let block = match uc.get_data().blocks.get(&(address, size)) {
        Some(block) => *block,
        None => {
            let code = uc.mem_read_as_vec(address.into(), size as usize)?;
            let watch = uc.get_data_mut();
            let instructions = watch.decoder.block(&code, address)?;
            let block = Count {
                instructions: instructions.len() as u64,
                cycles: watch.core.cycles(&instructions),
            };
            watch.blocks.insert((address, size), block);
            block
        }
    };
    let watch = uc.get_data_mut();
    if watch.end.is_some_and(|end| end != address) {
        watch.count.cycles += watch.core.taken();
    }
    watch.count.instructions += block.instructions;
    watch.count.cycles += block.cycles;
    watch.end = Some(address + size);
    Ok(())
}

/// The core, with a program.
pub struct Machine {
    uc: Unicorn<'static, Watch>,
}

impl Machine {
    /// A core with this program in its memory.
    pub fn new(core: Core, image: &Image) -> Result<Self> {
        let watch = Watch {
            core,
            decoder: Decoder::new()?,
            blocks: HashMap::new(),
            count: Count::default(),
            end: None,
            looks: Vec::new(),
            lookers: Vec::new(),
            failure: None,
        };
        // With `Mode::MCLASS` every core would be a Cortex-M33, whatever model is asked for.
        let mut uc = Unicorn::new_with_data(Arch::ARM, Mode::THUMB, watch)?;
        let model = match core {
            Core::M4f => ArmCpuModel::CORTEX_M4,
            Core::M7 => ArmCpuModel::CORTEX_M7,
        };
        uc.ctl_set_cpu_model(model as i32)?;
        uc.mem_map(FLASH.0.into(), FLASH.1.into(), Prot::READ | Prot::EXEC)?;
        for (from, size) in [RAM, STACK] {
            uc.mem_map(from.into(), size.into(), Prot::READ | Prot::WRITE)?;
        }
        for (address, data) in &image.segments {
            let written = uc.mem_write((*address).into(), data);
            written.context("a segment outside of memory")?;
        }
        uc.add_block_hook(1, 0, |uc, address, size| {
            if let Err(error) = enter(uc, address as u32, size) {
                uc.get_data_mut().failure.get_or_insert(error);
                let _ = uc.emu_stop();
            }
        })?;
        Ok(Self { uc })
    }

    /// Has the word at this address show the cycles of a call whenever the program looks at it.
    pub fn count_at(&mut self, address: u32) -> Result<()> {
        let (from, to) = (address.into(), u64::from(address) + 3);
        self.uc
            .add_mem_hook(HookType::MEM_READ, from, to, move |uc, _, _, _, _| {
                let at = uc.reg_read(RegisterARM::PC).unwrap_or_default() as u32;
                let watch = uc.get_data_mut();
                let cycles = watch.count.cycles as u32;
                watch.looks.push(cycles);
                watch.lookers.push(at);
                uc.mem_write(from, &cycles.to_le_bytes()).is_ok()
            })?;
        Ok(())
    }

    /// Cycles at each look at the counter in the last call.
    pub fn looks(&self) -> &[u32] {
        &self.uc.get_data().looks
    }

    /// Addresses of the instructions that look.
    pub fn lookers(&self) -> &[u32] {
        &self.uc.get_data().lookers
    }

    /// Calls a function; returns its result and the counts.
    pub fn call(&mut self, function: u32) -> Result<(u32, Count)> {
        let watch = self.uc.get_data_mut();
        (watch.count, watch.end) = (Count::default(), None);
        watch.looks.clear();
        watch.lookers.clear();
        self.uc
            .reg_write(RegisterARM::SP, (STACK.0 + STACK.1).into())?;
        self.uc.reg_write(RegisterARM::LR, (RETURN | 1).into())?;
        let end = self
            .uc
            .emu_start((function | 1).into(), RETURN.into(), 0, 0);
        if let Some(error) = self.uc.get_data_mut().failure.take() {
            return Err(error);
        }
        let at = self.uc.reg_read(RegisterARM::PC)?;
        end.with_context(|| format!("the program failed at {at:#x}"))?;
        ensure!(at as u32 & !1 == RETURN, "the program stopped at {at:#x}");
        let result = self.uc.reg_read(RegisterARM::R0)?;
        Ok((result as u32, self.uc.get_data().count))
    }

    /// Calls a function and tells how many bytes of stack it touched.
    pub fn stack_of(&mut self, function: u32) -> Result<u64> {
        let size = STACK.1 as usize;
        self.write(STACK.0, &vec![PAINT; size])?;
        self.call(function)?;
        let stack = self.read(STACK.0, size)?;
        let unused = stack.iter().take_while(|byte| **byte == PAINT).count();
        Ok((size - unused) as u64)
    }

    /// The memory, but for the stack.
    pub fn memory(&self) -> Result<Vec<u8>> {
        self.read(RAM.0, RAM.1 as usize)
    }

    /// Puts the memory back.
    pub fn restore(&mut self, memory: &[u8]) -> Result<()> {
        self.write(RAM.0, memory)
    }

    /// Reads memory.
    pub fn read(&self, address: u32, length: usize) -> Result<Vec<u8>> {
        Ok(self.uc.mem_read_as_vec(address.into(), length)?)
    }

    /// Reads a word.
    pub fn word(&self, address: u32) -> Result<u32> {
        let mut bytes = [0; 4];
        self.uc.mem_read(address.into(), &mut bytes)?;
        Ok(u32::from_le_bytes(bytes))
    }

    /// Writes memory.
    pub fn write(&mut self, address: u32, data: &[u8]) -> Result<()> {
        Ok(self.uc.mem_write(address.into(), data)?)
    }
}
