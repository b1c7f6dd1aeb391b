//! A solver on the emulated core: questions in, answers and counts out.

use crate::image::Image;
use crate::machine::{Counts, Machine};
use anyhow::{Context, Result, bail};
use host_tests::dispatch::Precision;
use spindle_bearing::{Design, FreeContact};
use tools::timing::Core;

/// What to solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Question {
    /// `Fx, Fy, Fz, My, Mz`, N and N m, of which a scene takes as many as it has freedoms; the
    /// displacement in the place of a load where that is given.
    pub load: [f64; 5],
    /// Shaft speed, rad/s.
    pub omega: f64,
    /// Tolerance of the stiffness.
    pub tolerance: f64,
    /// Most iterations.
    pub max_iterations: u32,
}

/// What the solver answered, widened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Displacement, m and rad; 0 of freedoms that the scene has not.
    pub displacement: [f64; 5],
    /// Stiffness, SI; 0 beyond that of the scene's freedoms.
    pub stiffness: [[f64; 5]; 5],
    /// The solver's own estimates of its errors.
    pub error: [f64; 3],
    /// There is one, and it is within the tolerance or as good as the precision allows.
    pub solved: bool,
    /// Iterations; 0 if there is no answer.
    pub iterations: u32,
}

/// A solve, counted.
pub struct Solve {
    /// What came of it.
    pub answer: Answer,
    /// Its counts, with those of the call around it.
    pub counts: Counts,
    /// Modelled cycles, without those.
    pub cycles: u64,
    /// Instructions, without those.
    pub instructions: u64,
}

/// A program on the emulated core.
pub struct Bench {
    precision: Precision,
    /// Bytes of a number, and numbers of displacement and stiffness.
    shape: [usize; 3],
    /// The program.
    pub image: Image,
    /// The core.
    pub machine: Machine,
    overhead: (u64, u64),
}

impl Bench {
    /// Puts a program on the core.
    pub fn new(image: Image, core: Core, precision: Precision) -> Result<Self> {
        let machine = Machine::new(core, &image)?;
        let mut bench = Self {
            precision,
            shape: [0; 3],
            image,
            machine,
            overhead: (0, 0),
        };
        let [_, _, number, vector, matrix] = bench.words()?.map(|word| word as usize);
        bench.shape = [number, vector / number, matrix / number];
        let (_, counts) = bench.call("measured_nothing")?;
        bench.overhead = (
            bench.machine.cycles(&counts),
            bench.machine.instructions(&counts),
        );
        Ok(bench)
    }

    fn call(&mut self, function: &str) -> Result<(u32, Counts)> {
        let address = self.image.symbol(function)?;
        self.machine
            .call(address)
            .with_context(|| format!("{function} of {}", self.image.path.display()))
    }

    fn bytes(&self, values: &[f64]) -> Vec<u8> {
        let of = |x: &f64| match self.precision {
            Precision::F32 => (*x as f32).to_le_bytes().to_vec(),
            Precision::F64 => x.to_le_bytes().to_vec(),
        };
        values.iter().flat_map(of).collect()
    }

    fn numbers(&self, bytes: &[u8]) -> Vec<f64> {
        match self.precision {
            Precision::F32 => bytes
                .as_chunks::<4>()
                .0
                .iter()
                .map(|b| f32::from_le_bytes(*b).into())
                .collect(),
            Precision::F64 => bytes
                .as_chunks::<8>()
                .0
                .iter()
                .map(|b| f64::from_le_bytes(*b))
                .collect(),
        }
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
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let at = self.image.symbol("MEASURED_DESIGN")?;
        self.machine.write(at, &bytes)?;
        match self.call("measured_build")? {
            (1, _) => Ok(()),
            _ => bail!("the solver refuses the design {design:?}"),
        }
    }

    /// Makes the next solve a cold one.
    pub fn reset(&mut self) -> Result<()> {
        self.call("measured_reset").map(drop)
    }

    fn ask(&mut self, question: &Question) -> Result<()> {
        let mut bytes = self.bytes(&question.load[..self.shape[1]]);
        bytes.extend(self.bytes(&[question.omega, question.tolerance]));
        bytes.extend(question.max_iterations.to_le_bytes());
        let at = self.image.symbol("MEASURED_QUESTION")?;
        self.machine.write(at, &bytes)
    }

    /// Solves.
    pub fn solve(&mut self, question: &Question) -> Result<Solve> {
        self.ask(question)?;
        let (_, counts) = self.call("measured_solve")?;
        let (cycles, instructions) = self.overhead;
        Ok(Solve {
            answer: self.answer()?,
            cycles: self.machine.cycles(&counts).saturating_sub(cycles),
            instructions: self
                .machine
                .instructions(&counts)
                .saturating_sub(instructions),
            counts,
        })
    }

    fn answer(&self) -> Result<Answer> {
        let [size, freedoms, elements] = self.shape;
        let all = freedoms + elements + 3;
        let at = self.image.symbol("MEASURED_ANSWER")?;
        let bytes = self.machine.read(at, all * size + 8)?;
        let numbers = self.numbers(&bytes[..all * size]);
        let (displacement, rest) = numbers.split_at(freedoms);
        let (stiffness, error) = rest.split_at(elements);
        let words: Vec<u32> = bytes[all * size..]
            .as_chunks::<4>()
            .0
            .iter()
            .map(|b| u32::from_le_bytes(*b))
            .collect();
        Ok(Answer {
            displacement: padded(displacement),
            stiffness: square(stiffness),
            error: std::array::from_fn(|i| error[i]),
            solved: matches!(words[0], 1 | 2),
            iterations: if words[0] == 0 { 0 } else { words[1] },
        })
    }

    /// Bytes of stack that a solve takes, beyond those of the call around it.
    pub fn stack(&mut self, question: &Question) -> Result<u32> {
        self.ask(question)?;
        let nothing = self.image.symbol("measured_nothing")?;
        let solve = self.image.symbol("measured_solve")?;
        let around = self.machine.stack_of(nothing)?;
        let all = self.machine.stack_of(solve)?;
        Ok(all.saturating_sub(around))
    }

    /// Bytes of the solver and of the bearing's constants.
    pub fn sizes(&self) -> Result<[u32; 2]> {
        let [solver, bearing, ..] = self.words()?;
        Ok([solver, bearing])
    }

    fn words(&self) -> Result<[u32; 5]> {
        let at = self.image.symbol("MEASURED_SIZES")?;
        let bytes = self.machine.read(at, 20)?;
        Ok(std::array::from_fn(|i| {
            u32::from_le_bytes(std::array::from_fn(|j| bytes[4 * i + j]))
        }))
    }
}

/// Zeros behind the numbers of a smaller scene.
pub fn padded(numbers: &[f64]) -> [f64; 5] {
    std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(0.0))
}

/// The same of a square matrix, row by row.
pub fn square(elements: &[f64]) -> [[f64; 5]; 5] {
    let mut rows = elements.chunks(elements.len().isqrt().max(1));
    std::array::from_fn(|_| padded(rows.next().unwrap_or(&[])))
}
