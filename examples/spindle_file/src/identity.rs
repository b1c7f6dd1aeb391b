//! Checksums that tell spindles apart, for data that a board keeps over a power cycle.
//!
//! They are of a file's numbers alone, in single precision, as the board has them. Words, keys left out for their
//! defaults, and the form of a number change none.

use crate::spindles::{Heat, SpindleFile};
use crc::{CRC_32_ISO_HDLC, Crc, Digest};
use spindle_bearing::{
    Design, Expansion, FreeContact, Growth, Material, Preload, Section, ShaftLoad, Support,
};

static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A checksum of numbers in their order.
struct Sum(Digest<'static, u32>);

impl Sum {
    fn new() -> Self {
        Self(CHECKSUM.digest())
    }

    /// Takes numbers, a negative 0 as 0.
    fn take(&mut self, numbers: impl IntoIterator<Item = f64>) {
        for number in numbers {
            self.0.update(&(number as f32 + 0.0).to_le_bytes());
        }
    }

    /// Takes the number of things that follow.
    fn count(&mut self, things: usize) {
        self.take([things as f64]);
    }

    fn material(&mut self, material: &Material) {
        let Material {
            youngs_modulus,
            poissons_ratio,
            density,
        } = *material;
        self.take([youngs_modulus, poissons_ratio, density]);
    }

    fn design(&mut self, design: &Design) {
        let Design {
            ball_diameter,
            pitch_diameter,
            inner_groove_factor,
            outer_groove_factor,
            free_contact,
            inner_shoulder_angle,
            outer_shoulder_angle,
            first_ball,
            ring,
            ball,
        } = design;
        let free_contact = match free_contact {
            FreeContact::Angle(angle) => [0.0, *angle],
            FreeContact::DiametralClearance(clearance) => [1.0, *clearance],
        };
        self.take([*ball_diameter, *pitch_diameter]);
        self.take([*inner_groove_factor, *outer_groove_factor]);
        self.take(free_contact);
        self.take([*inner_shoulder_angle, *outer_shoulder_angle, *first_ball]);
        self.material(ring);
        self.material(ball);
    }

    fn bearings(&mut self, file: &SpindleFile) {
        for row in &file.plan.rows {
            self.count(row.balls);
            self.take([row.facing.sign()]);
            self.design(&row.design);
        }
    }
}

impl SpindleFile {
    /// Checksum of the bearings, row by row: designs, ball counts, facings. Life and alarms are theirs.
    pub fn bearings_checksum(&self) -> u32 {
        let mut sum = Sum::new();
        sum.bearings(self);
        sum.0.finalize()
    }

    /// Checksum of all numbers that computed displacements at the probes depend on. Their references are of these.
    ///
    /// Besides the bearings: places, preload, supports, growth, shaft, constant loads, the place of recorded loads, the
    /// probes, and a calibration of strain bridges.
    pub fn displacements_checksum(&self) -> u32 {
        let mut sum = Sum::new();
        sum.bearings(self);
        let shaft = self.plan.shaft.as_ref();
        for (i, row) in self.plan.rows.iter().enumerate() {
            let preload = match (row.preload, &self.plan.mounted_preload) {
                (_, Some((force, _))) => [0.0, *force],
                (Preload::Closure(closure), None) => [1.0, closure],
                (Preload::Force(force), None) => [2.0, force],
                (_, None) => [3.0, self.plan.spring.unwrap_or_default()],
            };
            sum.take([row.position]);
            sum.take(preload);
            let Support {
                axial,
                radial,
                tilting,
            } = shaft.map_or(Support::RIGID, |shaft| shaft.supports[i]);
            sum.take([axial, radial, tilting]);
            let Growth {
                axial,
                radial,
                ball,
            } = self.growth[i];
            sum.take([axial, radial, ball]);
            // A ring that does not grow with the speed has no bore.
            sum.take([self.bores.get(i).copied().unwrap_or(-1.0)]);
        }
        let sections = shaft.map_or(&[][..], |shaft| &shaft.sections);
        sum.count(sections.len());
        for Section {
            from,
            to,
            outer,
            inner,
        } in sections
        {
            sum.take([*from, *to, *outer, *inner]);
        }
        if let Some(shaft) = shaft.filter(|_| !sections.is_empty()) {
            sum.material(&shaft.material);
        }
        let of_rigid = self.constant_loads();
        let loads = shaft.map_or(&of_rigid, |shaft| &shaft.loads);
        sum.count(loads.len());
        for ShaftLoad { position, load } in loads {
            sum.take([*position]);
            sum.take(*load);
        }
        sum.take([self.loaded_at()]);
        sum.count(self.heat.iter().len());
        if let Some(Heat {
            reference,
            expansion,
            ..
        }) = self.heat
        {
            let Expansion {
                shaft,
                housing,
                ring,
                ball,
            } = expansion;
            sum.take([reference, shaft, housing, ring, ball]);
        }
        sum.count(self.probes.len());
        for probe in &self.probes {
            sum.take([probe.position]);
            sum.take(probe.direction);
            sum.count(probe.channel.iter().len());
            if let Some((channel, um_per_count)) = probe.channel {
                sum.take([channel as f64, um_per_count]);
            }
        }
        let bridges = self.sensors.bridges.as_ref();
        sum.count(bridges.map_or(0, |bridges| bridges.counts.len()));
        if let Some(bridges) = bridges {
            sum.take(
                bridges
                    .counts
                    .iter()
                    .chain(&bridges.loads)
                    .flatten()
                    .copied(),
            );
            // The tare stands for these loads.
            sum.take(self.sensors.idle.map(f64::from));
        }
        sum.0.finalize()
    }
}
