//! An emulated core that runs one function of a program at a time, and counts.
//!
//! The emulator reports every block of instructions that it runs. A block is decoded once.

use crate::decode::Decoder;
use crate::image::Image;
use crate::timing::Core;
use crate::unicorn::{
    CORTEX_M4, CORTEX_M7, EXECUTE, Emulator, Hooks, Memory, READ, Register, WRITE,
};
use crate::wheels;
use anyhow::{Context, Result, ensure};
use std::collections::HashMap;

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

impl Watch {
    /// Counts a block that begins.
    fn enter(&mut self, memory: &Memory, address: u32, size: u32) -> Result<()> {
        let block = match self.blocks.get(&(address, size)) {
            Some(block) => *block,
            None => {
                let code = memory.read(address, size as usize)?;
                let instructions = self.decoder.block(&code, address)?;
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

    /// Shows the cycles of the call to a program that looks at the counter.
    fn show(&mut self, memory: &Memory, address: u32) -> Result<()> {
        let cycles = self.count.cycles as u32;
        self.looks.push(cycles);
        self.lookers.push(memory.register(Register::Pc)?);
        memory.write(address, &cycles.to_le_bytes())
    }

    /// Keeps the first failure, which ends the run.
    fn keep(&mut self, memory: &Memory, done: Result<()>) {
        if let Err(error) = done {
            self.failure.get_or_insert(error);
            memory.stop();
        }
    }
}

impl Hooks for Watch {
    fn block(&mut self, memory: &Memory, address: u32, size: u32) {
        let done = self.enter(memory, address, size);
        self.keep(memory, done);
    }

    fn read(&mut self, memory: &Memory, address: u32) {
        let done = self.show(memory, address);
        self.keep(memory, done);
    }
}

/// The core, with a program.
pub struct Machine {
    core: Emulator<Watch>,
}

impl Machine {
    /// A core with this program in its memory.
    pub fn new(core: Core, image: &Image) -> Result<Self> {
        let wheels = wheels::open()?;
        let watch = Watch {
            core,
            decoder: Decoder::new(&wheels.capstone)?,
            blocks: HashMap::new(),
            count: Count::default(),
            end: None,
            looks: Vec::new(),
            lookers: Vec::new(),
            failure: None,
        };
        let model = match core {
            Core::M4f => CORTEX_M4,
            Core::M7 => CORTEX_M7,
        };
        let core = Emulator::new(&wheels.unicorn, model, watch)?;
        core.memory().map(FLASH, READ | EXECUTE)?;
        for ram in [RAM, STACK] {
            core.memory().map(ram, READ | WRITE)?;
        }
        for (address, data) in &image.segments {
            let written = core.memory().write(*address, data);
            written.context("a segment outside of memory")?;
        }
        Ok(Self { core })
    }

    /// Has the word at this address show the cycles of a call whenever the program looks at it.
    pub fn count_at(&mut self, address: u32) -> Result<()> {
        self.core.watch(address)
    }

    /// Cycles at each look at the counter in the last call.
    pub fn looks(&self) -> &[u32] {
        &self.core.hooks().looks
    }

    /// Addresses of the instructions that look.
    pub fn lookers(&self) -> &[u32] {
        &self.core.hooks().lookers
    }

    /// Calls a function; returns its result and the counts.
    pub fn call(&mut self, function: u32) -> Result<(u32, Count)> {
        let watch = self.core.hooks_mut();
        (watch.count, watch.end) = (Count::default(), None);
        watch.looks.clear();
        watch.lookers.clear();
        let registers = [
            (Register::Sp, STACK.0 + STACK.1),
            (Register::Lr, RETURN | 1),
        ];
        for (register, value) in registers {
            self.core.memory().set_register(register, value)?;
        }
        let run = self.core.run(function | 1, RETURN);
        if let Some(error) = self.core.hooks_mut().failure.take() {
            return Err(error);
        }
        run.context("the program failed")?;
        let at = self.core.memory().register(Register::Pc)?;
        ensure!(at & !1 == RETURN, "the program stopped at {at:#x}");
        let result = self.core.memory().register(Register::R0)?;
        Ok((result, self.core.hooks().count))
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
        self.core.memory().read(address, length)
    }

    /// Reads a word.
    pub fn word(&self, address: u32) -> Result<u32> {
        let bytes = self.read(address, 4)?;
        let word = bytes.first_chunk().context("a word has four bytes")?;
        Ok(u32::from_le_bytes(*word))
    }

    /// Writes memory.
    pub fn write(&self, address: u32, data: &[u8]) -> Result<()> {
        self.core.memory().write(address, data)
    }
}
