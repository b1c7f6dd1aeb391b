//! An emulated core that runs one function of a program at a time, and counts.
//!
//! The emulator reports every block of instructions that it runs. A block is decoded once; how often
//! it ran, and under which calls, is all that is counted.

use crate::decode::{Decoder, End};
use crate::image::Image;
use anyhow::{Context, Result, anyhow, bail};
use std::collections::HashMap;
use tools::timing::{self, Class, Core};
use unicorn_engine::unicorn_const::{Arch, ArmCpuModel, Mode, Prot};
use unicorn_engine::{RegisterARM, Unicorn};

const FLASH: (u32, u32) = (0x0800_0000, 0x10_0000);
const RAM: (u32, u32) = (0x2000_0000, 0x2_0000);
/// Where functions return to: the end of flash.
const RETURN: u32 = FLASH.0 + FLASH.1 - 16;
/// Bytes at the start of RAM that are kept for the program's statics; the rest is stack.
const DATA: usize = 0x1_0000;
/// What the stack is painted with.
const PAINT: u8 = 0xA5;

/// A block of instructions.
pub struct Block {
    /// Address of every instruction, with its cycles and class.
    pub instructions: Vec<(u32, u32, Class)>,
    /// Sum of the cycles.
    pub cycles: u64,
    /// Address behind it.
    pub end: u32,
    kind: End,
}

/// A function that runs, called from somewhere.
pub struct Node {
    /// Who calls, and the address of the call; none of a function that was called from outside.
    pub caller: Option<(usize, u32)>,
    children: HashMap<(usize, u32), usize>,
}

/// How often a block ran, and how often it ended in a taken branch.
#[derive(Debug, Clone, Copy, Default)]
pub struct Runs {
    /// All.
    pub all: u64,
    /// Those.
    pub taken: u64,
}

/// Counts by calling function and block.
pub type Counts = HashMap<(usize, usize), Runs>;

/// A block under a calling function, with what followed it so far.
struct Slot {
    node: usize,
    block: usize,
    runs: Runs,
    next: Vec<Edge>,
}

/// From a block to the next one. It is the same whenever it is taken: a function under a caller
/// returns to that caller only.
#[derive(Clone, Copy)]
struct Edge {
    address: u32,
    size: u32,
    slot: usize,
    taken: bool,
    flow: Flow,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Flow {
    Within,
    Call,
    Return,
}

struct Watch {
    core: Core,
    decoder: Decoder,
    flash: Vec<u8>,
    index: HashMap<(u32, u32), usize>,
    blocks: Vec<Block>,
    nodes: Vec<Node>,
    slots: Vec<Slot>,
    by_place: HashMap<(usize, usize), usize>,
    /// Where functions that run return to, and the slot that called them.
    returns: Vec<(u32, usize)>,
    last: Option<usize>,
    failure: Option<anyhow::Error>,
}

impl Watch {
    fn find(&mut self, address: u32, size: u32) -> Result<usize> {
        if let Some(found) = self.index.get(&(address, size)) {
            return Ok(*found);
        }
        let from = (address - FLASH.0) as usize;
        let code = self
            .flash
            .get(from..from + size as usize)
            .context("instructions outside of flash")?;
        let (instructions, kind) = self.decoder.block(code, address)?;
        let timed: Vec<_> = instructions.iter().map(|i| i.timed).collect();
        let cycles = timing::cycles(self.core, &timed);
        let number = self.blocks.len();
        self.blocks.push(Block {
            cycles: cycles.iter().map(|c| u64::from(*c)).sum(),
            instructions: instructions
                .iter()
                .zip(cycles)
                .map(|(i, cycles)| (i.address, cycles, i.timed.class))
                .collect(),
            end: address + size,
            kind,
        });
        self.index.insert((address, size), number);
        Ok(number)
    }

    fn slot(&mut self, node: usize, block: usize) -> usize {
        *self.by_place.entry((node, block)).or_insert_with(|| {
            self.slots.push(Slot {
                node,
                block,
                runs: Runs::default(),
                next: Vec::new(),
            });
            self.slots.len() - 1
        })
    }

    /// The edge from a slot to a block that it was not followed by before.
    fn edge(&mut self, last: usize, address: u32, size: u32) -> Result<Edge> {
        let block = self.find(address, size)?;
        let Slot {
            node, block: from, ..
        } = self.slots[last];
        let before = &self.blocks[from];
        let taken = before.end != address;
        let (node, flow) = if taken && before.kind == End::Call {
            let call = before.instructions.last().map_or(0, |i| i.0);
            let next = self.nodes.len();
            let callee = *self.nodes[node]
                .children
                .entry((from, address))
                .or_insert(next);
            if callee == next {
                self.nodes.push(Node {
                    caller: Some((node, call)),
                    children: HashMap::new(),
                });
            }
            (callee, Flow::Call)
        } else if let Some((to, caller)) = self.returns.last()
            && taken
            && *to == address
        {
            (self.slots[*caller].node, Flow::Return)
        } else {
            (node, Flow::Within)
        };
        let edge = Edge {
            address,
            size,
            slot: self.slot(node, block),
            taken,
            flow,
        };
        self.slots[last].next.push(edge);
        Ok(edge)
    }

    fn enter(&mut self, address: u32, size: u32) -> Result<()> {
        let slot = match self.last {
            None => {
                let block = self.find(address, size)?;
                self.slot(0, block)
            }
            Some(last) => {
                let known = self.slots[last]
                    .next
                    .iter()
                    .find(|edge| edge.address == address && edge.size == size);
                let edge = match known {
                    Some(edge) => *edge,
                    None => self.edge(last, address, size)?,
                };
                self.slots[last].runs.taken += u64::from(edge.taken);
                match edge.flow {
                    Flow::Within => {}
                    Flow::Call => {
                        let end = self.blocks[self.slots[last].block].end;
                        self.returns.push((end, last));
                    }
                    Flow::Return => {
                        self.returns.pop();
                    }
                }
                edge.slot
            }
        };
        self.slots[slot].runs.all += 1;
        self.last = Some(slot);
        Ok(())
    }

    /// Starts over with counting.
    fn clear(&mut self) {
        for slot in &mut self.slots {
            slot.runs = Runs::default();
        }
        self.returns.clear();
        self.last = None;
    }

    fn counts(&self) -> Counts {
        self.slots
            .iter()
            .filter(|slot| slot.runs.all > 0)
            .map(|slot| ((slot.node, slot.block), slot.runs))
            .collect()
    }
}

/// The core, with a program.
pub struct Machine {
    uc: Unicorn<'static, Watch>,
}

fn failed(what: &str) -> impl FnOnce(unicorn_engine::uc_error) -> anyhow::Error + '_ {
    move |e| anyhow!("the emulator cannot {what}: {e:?}")
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
            let from = address
                .checked_sub(start)
                .context("a segment outside of memory")? as usize;
            memory
                .get_mut(from..from + data.len())
                .context("a segment outside of memory")?
                .copy_from_slice(data);
        }
        let watch = Watch {
            core,
            decoder: Decoder::new()?,
            flash: flash.clone(),
            index: HashMap::new(),
            blocks: Vec::new(),
            nodes: vec![Node {
                caller: None,
                children: HashMap::new(),
            }],
            slots: Vec::new(),
            by_place: HashMap::new(),
            returns: Vec::new(),
            last: None,
            failure: None,
        };
        // With `Mode::MCLASS` every core would be a Cortex-M33, whatever model is asked for.
        let mut uc =
            Unicorn::new_with_data(Arch::ARM, Mode::THUMB, watch).map_err(failed("start"))?;
        let model = match core {
            Core::M4f => ArmCpuModel::CORTEX_M4,
            Core::M7 => ArmCpuModel::CORTEX_M7,
        };
        uc.ctl_set_cpu_model(model as i32)
            .map_err(failed("be this core"))?;
        for ((start, size), data, use_of) in [
            (FLASH, &flash, Prot::READ | Prot::EXEC),
            (RAM, &ram, Prot::READ | Prot::WRITE),
        ] {
            uc.mem_map(start.into(), size.into(), use_of)
                .map_err(failed("map memory"))?;
            uc.mem_write(start.into(), data)
                .map_err(failed("fill memory"))?;
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
        .map_err(failed("report what it runs"))?;
        Ok(Self { uc })
    }

    /// Calls a function; returns what it returns and what was counted.
    pub fn call(&mut self, function: u32) -> Result<(u32, Counts)> {
        self.uc.get_data_mut().clear();
        let stack = RAM.0 + RAM.1;
        for (register, value) in [(RegisterARM::SP, stack), (RegisterARM::LR, RETURN | 1)] {
            self.uc
                .reg_write(register, value.into())
                .map_err(failed("set a register"))?;
        }
        let end = self
            .uc
            .emu_start((function | 1).into(), RETURN.into(), 0, 0);
        if let Some(error) = self.uc.get_data_mut().failure.take() {
            return Err(error);
        }
        let at = self
            .uc
            .reg_read(RegisterARM::PC)
            .map_err(failed("tell where it is"))?;
        end.map_err(|e| anyhow!("the program failed at {at:#x}: {e:?}"))?;
        if at as u32 & !1 != RETURN {
            bail!("the program stopped at {at:#x}");
        }
        let value = self
            .uc
            .reg_read(RegisterARM::R0)
            .map_err(failed("tell a register"))?;
        Ok((value as u32, self.uc.get_data().counts()))
    }

    /// Calls a function and tells how many bytes of stack it touched.
    pub fn stack_of(&mut self, function: u32) -> Result<u32> {
        let lowest = RAM.0 + DATA as u32;
        let top = RAM.0 + RAM.1;
        self.write(lowest, &vec![PAINT; (top - lowest) as usize])?;
        self.call(function)?;
        let left = self
            .read(lowest, (top - lowest) as usize)?
            .iter()
            .take_while(|byte| **byte == PAINT)
            .count();
        Ok(top - lowest - left as u32)
    }

    /// What is in memory, but for the stack.
    pub fn memory(&self) -> Result<Vec<u8>> {
        self.read(RAM.0, DATA)
    }

    /// Puts back what was in memory.
    pub fn restore(&mut self, memory: &[u8]) -> Result<()> {
        self.write(RAM.0, memory)
    }

    /// Reads memory.
    pub fn read(&self, address: u32, length: usize) -> Result<Vec<u8>> {
        self.uc
            .mem_read_as_vec(address.into(), length)
            .map_err(failed("read memory"))
    }

    /// Writes memory.
    pub fn write(&mut self, address: u32, data: &[u8]) -> Result<()> {
        self.uc
            .mem_write(address.into(), data)
            .map_err(failed("write memory"))
    }

    /// The blocks that ran so far.
    pub fn blocks(&self) -> &[Block] {
        &self.uc.get_data().blocks
    }

    /// The functions that ran so far.
    pub fn nodes(&self) -> &[Node] {
        &self.uc.get_data().nodes
    }

    /// Modelled cycles of what was counted.
    pub fn cycles(&self, counts: &Counts) -> u64 {
        let watch = self.uc.get_data();
        let taken = u64::from(timing::taken(watch.core));
        counts
            .iter()
            .map(|((_, block), runs)| runs.all * watch.blocks[*block].cycles + runs.taken * taken)
            .sum()
    }

    /// Instructions of what was counted.
    pub fn instructions(&self, counts: &Counts) -> u64 {
        let blocks = self.blocks();
        counts
            .iter()
            .map(|((_, block), runs)| runs.all * blocks[*block].instructions.len() as u64)
            .sum()
    }
}
