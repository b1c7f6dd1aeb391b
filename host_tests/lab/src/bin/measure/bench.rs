//! A solver on the emulated core: questions in, answers and counts out.

use crate::image::Image;
use crate::machine::{Count, Machine};
use crate::timing::Core;
use anyhow::{Result, bail};
use lab::solves::State;
use solvers::dispatch::Precision;
use spindle_bearing::{Design, FreeContact};

/// An answer; equal answers are equal to the last bit.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Bits of the displacements (m and rad), then of the stiffness, row by row, of a scene's freedoms. They
    /// are widened to double precision exactly.
    bits: Vec<u64>,
    iterations: u32,
}

impl Answer {
    /// Of these numbers.
    pub fn new(numbers: impl Iterator<Item = f64>, iterations: u32) -> Self {
        Self {
            bits: numbers.map(f64::to_bits).collect(),
            iterations,
        }
    }

    /// The stiffness for five freedoms.
    pub fn stiffness(&self) -> [[f64; 5]; 5] {
        let at = |i: usize, j: usize| f64::from_bits(self.bits[5 + 5 * i + j]);
        std::array::from_fn(|i| std::array::from_fn(|j| at(i, j)))
    }
}

/// A program on the emulated core.
pub struct Bench {
    /// The program.
    pub image: Image,
    /// The core.
    pub machine: Machine,
    precision: Precision,
    freedoms: usize,
    /// Of the call around a solve.
    overhead: Count,
}

impl Bench {
    /// Puts a program on the core.
    pub fn new(image: Image, core: Core, precision: Precision, freedoms: usize) -> Result<Self> {
        let mut bench = Self {
            precision,
            freedoms,
            machine: Machine::new(core, &image)?,
            image,
            overhead: Count::default(),
        };
        (_, bench.overhead) = bench.call("measured_nothing")?;
        Ok(bench)
    }

    fn call(&mut self, function: &str) -> Result<(u32, Count)> {
        let address = self.image.symbol(function)?;
        self.machine.call(address)
    }

    /// Builds the bearing and a solver without history.
    pub fn bearing(&mut self, design: &Design) -> Result<()> {
        let FreeContact::Angle(angle) = design.free_contact else {
            bail!("only designs with a free contact angle are measured");
        };
        let (ring, ball) = (design.ring, design.ball);
        let numbers = [
            design.ball_diameter,
            design.pitch_diameter,
            design.inner_groove_factor,
            design.outer_groove_factor,
            angle,
            design.first_ball,
            ring.youngs_modulus,
            ring.poissons_ratio,
            ring.density,
            ball.youngs_modulus,
            ball.poissons_ratio,
            ball.density,
        ];
        let at = self.image.symbol("MEASURED_DESIGN")?;
        self.machine
            .write(at, &numbers.map(f64::to_le_bytes).concat())?;
        match self.call("measured_build")? {
            (1, _) => Ok(()),
            _ => bail!("the solver refuses the design {design:?}"),
        }
    }

    fn ask(&mut self, (load, omega): State, tolerance: f64) -> Result<()> {
        let numbers = load[..self.freedoms].iter().chain([&omega, &tolerance]);
        let bytes: Vec<u8> = match self.precision {
            Precision::F32 => numbers.flat_map(|x| (*x as f32).to_le_bytes()).collect(),
            Precision::F64 => numbers.flat_map(|x| x.to_le_bytes()).collect(),
        };
        let at = self.image.symbol("MEASURED_QUESTION")?;
        self.machine.write(at, &bytes)
    }

    /// Solves.
    pub fn solve(&mut self, state: State, tolerance: f64) -> Result<(Option<Answer>, Count)> {
        self.ask(state, tolerance)?;
        let (_, count) = self.call("measured_solve")?;
        Ok((self.answer()?, count.less(self.overhead)))
    }

    fn answer(&self) -> Result<Option<Answer>> {
        let count = self.freedoms * (1 + self.freedoms);
        let at = self.image.symbol("MEASURED_ANSWER")?;
        let size = match self.precision {
            Precision::F32 => 4,
            Precision::F64 => 8,
        };
        let behind = at + (count * size) as u32;
        let [iterations, solved] = [self.machine.word(behind)?, self.machine.word(behind + 4)?];
        let bytes = self.machine.read(at, count * size)?;
        let number = |bytes: &[u8]| match *bytes {
            [a, b, c, d] => f32::from_le_bytes([a, b, c, d]).into(),
            _ => bytes.try_into().map_or(f64::NAN, f64::from_le_bytes),
        };
        let answer = Answer::new(bytes.chunks_exact(size).map(number), iterations);
        Ok((solved != 0).then_some(answer))
    }

    /// Bytes of stack that a solve takes, beyond the call around it.
    pub fn stack(&mut self, state: State, tolerance: f64) -> Result<u64> {
        self.ask(state, tolerance)?;
        let [nothing, solve] =
            ["measured_nothing", "measured_solve"].map(|entry| self.image.symbol(entry));
        let around = self.machine.stack_of(nothing?)?;
        Ok(self.machine.stack_of(solve?)?.saturating_sub(around))
    }

    /// Bytes of a solver.
    pub fn state(&self) -> Result<u64> {
        let at = self.image.symbol("MEASURED_STATE")?;
        Ok(self.machine.word(at)?.into())
    }
}
