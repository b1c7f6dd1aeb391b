//! The elastic shaft of a spindle file, and the supports of its rows.

use crate::designs::{DesignFile, MODULI, RATIOS};
use crate::doubts::{Doubts, Extent};
use crate::plan::{MOST_SECTIONS, Row};
use crate::reading::{DesignFileError, Key, Place, Reading, millimetres, short};
use serde::Deserialize;
use spindle_bearing::{Growth, Material, Quantity, Section, Shaft, ShaftError, Support};
use std::ops::RangeInclusive;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ShaftKeys {
    bore_mm: Key<f64>,
    youngs_modulus_gpa: Key<f64>,
    poissons_ratio: Key<f64>,
    sections: Option<Vec<Spanned<SectionKeys>>>,
    grow_with_speed: Key<bool>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SectionKeys {
    from_mm: Spanned<f64>,
    to_mm: Spanned<f64>,
    outer_mm: Spanned<f64>,
    inner_mm: Key<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SupportKeys {
    axial_n_per_um: Key<f64>,
    radial_n_per_um: Key<f64>,
    tilting_nm_per_rad: Key<f64>,
}

/// Usual stiffness of a support along and across the axis, N/um: from a slender quill's to a rigid housing's, whose ring has half of
/// that by itself.
const SUPPORTS: RangeInclusive<f64> = 1.0..=20_000.0;
/// Largest usual stiffness against tilting, N m/rad: the largest radial one on an arm of 70 mm.
const MOST_TILTING: f64 = 1e8;

/// Least stiffness of a support that the library takes: along and across the axis, N/m, and against tilting, N m/rad.
const LEAST_SUPPORT: f64 = 1e5;
const LEAST_TILTING: f64 = 1.0;

impl SupportKeys {
    /// The support of the row of this number.
    pub fn read(
        &self,
        r: Reading<'_>,
        row: usize,
        doubts: &mut Doubts<'_>,
    ) -> Result<Support<f64>, DesignFileError> {
        let mut stiffness = |key: &str, value: &Key<f64>, unit: f64, least: f64| {
            let Some(value) = value else {
                return Ok(f64::INFINITY);
            };
            let (place, said) = (r.place(value.span()), *value.get_ref());
            if said * unit >= least {
                let (usual, question) = match unit {
                    1.0 => (least..=MOST_TILTING, "is it in N m/rad?"),
                    _ => (SUPPORTS, "is it in N/um?"),
                };
                doubts.unusual(place, (key, said), usual, question);
                return Ok(said * unit);
            }
            let least = least / unit;
            let message = format!(
                "row {row}: `{key}` is {said}, but must be {least} at least; leave it out for a rigid support"
            );
            Err(r.error(place, message))
        };
        Ok(Support {
            axial: stiffness("axial_n_per_um", &self.axial_n_per_um, 1e6, LEAST_SUPPORT)?,
            radial: stiffness("radial_n_per_um", &self.radial_n_per_um, 1e6, LEAST_SUPPORT)?,
            tilting: stiffness(
                "tilting_nm_per_rad",
                &self.tilting_nm_per_rad,
                1.0,
                LEAST_TILTING,
            )?,
        })
    }
}

impl SectionKeys {
    fn section(&self) -> Section {
        let inner = self.inner_mm.as_ref().map_or(0.0, |inner| *inner.get_ref());
        Section {
            from: millimetres(*self.from_mm.get_ref()),
            to: millimetres(*self.to_mm.get_ref()),
            outer: millimetres(*self.outer_mm.get_ref()),
            inner: millimetres(inner),
        }
    }
}

impl ShaftKeys {
    /// The sections, none if the file has no such key; and their material.
    pub fn sections(
        &self,
        r: Reading<'_>,
        doubts: &mut Doubts<'_>,
    ) -> Result<(Option<Vec<Section>>, Material), DesignFileError> {
        let mut material = Material::STEEL;
        let mut for_sections = None;
        if let Some(value) = &self.youngs_modulus_gpa {
            let (key, said) = ("youngs_modulus_gpa", *value.get_ref());
            material.youngs_modulus = said * 1e9;
            for_sections = Some((key, value.span()));
            doubts.unusual(r.place(value.span()), (key, said), MODULI, "is it in GPa?");
        }
        if let Some(value) = &self.poissons_ratio {
            let (key, said) = ("poissons_ratio", *value.get_ref());
            material.poissons_ratio = said;
            for_sections = Some((key, value.span()));
            doubts.unusual(
                r.place(value.span()),
                (key, said),
                RATIOS,
                "is it that ratio?",
            );
        }
        let Some(keys) = &self.sections else {
            let Some((key, span)) = for_sections else {
                return Ok((None, material));
            };
            let message = format!("`{key}` is for `sections`: add them, or remove it");
            return Err(r.error(r.place(span), message));
        };
        let sections: Vec<Section> = keys.iter().map(|keys| keys.get_ref().section()).collect();
        match Shaft::<f64, MOST_SECTIONS>::new(&sections, &material) {
            Ok(_) => Ok((Some(sections), material)),
            Err(error) => Err(self.explain(r, keys, &error)),
        }
    }

    /// The message for a shaft that the library refuses: its section, key and place, in the file's unit.
    fn explain(
        &self,
        r: Reading<'_>,
        sections: &[Spanned<SectionKeys>],
        ShaftError { section, error }: &ShaftError,
    ) -> DesignFileError {
        use Quantity as Q;
        let keys = sections.get(*section).map(Spanned::get_ref);
        let of_shaft = |key: &Key<f64>| key.as_ref().map(Spanned::span);
        let (key, span, unit) = match (error.quantity, keys) {
            (Q::ShaftYoungsModulus, _) => {
                let span = of_shaft(&self.youngs_modulus_gpa);
                ("youngs_modulus_gpa", span, 1e-9)
            }
            (Q::ShaftPoissonsRatio, _) => ("poissons_ratio", of_shaft(&self.poissons_ratio), 1.0),
            (Q::SectionStart, Some(keys)) => ("from_mm", Some(keys.from_mm.span()), 1e3),
            (Q::SectionEnd, Some(keys)) => ("to_mm", Some(keys.to_mm.span()), 1e3),
            (Q::OuterDiameter, Some(keys)) => ("outer_mm", Some(keys.outer_mm.span()), 1e3),
            (Q::InnerDiameter, Some(keys)) => ("inner_mm", of_shaft(&keys.inner_mm), 1e3),
            _ => ("sections", sections.get(*section).map(Spanned::span), 1.0),
        };
        let [value, least, most] = [error.value, error.least, error.most].map(|x| short(unit * x));
        let place = span.map_or(Place::TOP, |span| r.place(span));
        // Of two that overlap, the later one is at fault, and each is in range by itself.
        let mut before = sections.iter().take(*section);
        let beside = before.position(|other| other.get_ref().section().to == error.least);
        let extent = |i: usize| {
            let keys = sections[i].get_ref();
            let [from, to] = [&keys.from_mm, &keys.to_mm].map(|key| *key.get_ref());
            format!("section {i} (`from_mm` = {from}, `to_mm` = {to})")
        };
        let message = match (key, beside) {
            ("sections", _) => format!("[shaft] has {value} sections, and {most} at most here"),
            ("from_mm", Some(other)) => {
                format!("{} overlaps {}", extent(*section), extent(other))
            }
            ("youngs_modulus_gpa" | "poissons_ratio", _) => {
                format!("`{key}` of [shaft] is {value}, but must lie between {least} and {most}")
            }
            _ => format!(
                "section {section}: `{key}` is {value}, but must lie between {least} and {most}; sections count from 0"
            ),
        };
        r.error(place, message)
    }

    /// Bore at each of the `rows`, on which its ring grows with the speed, m; none if rings do not grow.
    ///
    /// Where two sections meet at a row, the larger bore counts: the rings grow more.
    pub fn bores(
        &self,
        r: Reading<'_>,
        table: Place,
        sections: Option<&[Section]>,
        rows: &[(&Row, Place)],
    ) -> Result<Vec<f64>, DesignFileError> {
        let grows = self.grow_with_speed.as_ref();
        let grows = grows.filter(|grows| *grows.get_ref());
        let place = grows.map(|grows| r.place(grows.span()));
        let rows = rows.iter().enumerate();
        match (&self.bore_mm, place, sections) {
            (Some(_), Some(place), _) => {
                let message = "rings grow by `grow_with_speed` or by `bore_mm`; remove one of them";
                Err(r.error(place, message))
            }
            (Some(bore), None, _) => {
                let (place, said) = (r.place(bore.span()), *bore.get_ref());
                rows.map(|(i, (row, _))| {
                    in_ring(row, millimetres(said)).ok_or_else(|| {
                        r.error(place, format!("`bore_mm` is {said}, {NO_RING} row {i}"))
                    })
                })
                .collect()
            }
            (None, Some(place), None) => {
                let message =
                    "`grow_with_speed` takes the bores of `sections`: add them, or give `bore_mm`";
                Err(r.error(place, message))
            }
            (None, Some(_), Some(sections)) => rows
                .map(|(i, (row, place))| {
                    let x = row.position;
                    let at = |section: &&Section| section.from <= x && x <= section.to;
                    let bores = sections.iter().filter(at).map(|section| section.inner);
                    let Some(bore) = bores.reduce(f64::max) else {
                        let message = format!(
                            "row {i} stands in no section of [shaft], and `grow_with_speed` takes its bore: add a section, or give `bore_mm`"
                        );
                        return Err(r.error(*place, message));
                    };
                    in_ring(row, bore).ok_or_else(|| {
                        let bore = short(1e3 * bore);
                        r.error(*place, format!("the section there has `inner_mm` = {bore}, {NO_RING} row {i}"))
                    })
                })
                .collect(),
            (None, None, None) if self.grow_with_speed.is_none() => {
                let message =
                    "[shaft] lacks `bore_mm`; add a line such as `bore_mm = 40`, or `sections`";
                Err(r.error(table, message))
            }
            (None, None, _) => Ok(Vec::new()),
        }
    }

    /// Doubts places of the `rows` that are off all sections, and diameters that do not fit the bores of their bearings, as far as
    /// these are known.
    pub fn doubt(
        &self,
        r: Reading<'_>,
        sections: Option<&[Section]>,
        rows: &[(&Row, Place)],
        designs: &[DesignFile],
        doubts: &mut Doubts<'_>,
    ) {
        let (sections, mut told) = (sections.unwrap_or_default(), Vec::new());
        for (i, ((row, place), design)) in rows.iter().zip(designs).enumerate() {
            let alone = Extent::drawn(sections, row.design.pitch_diameter);
            if !sections.is_empty() && alone.is_beyond(row.position) {
                let words = alone.words(row.position);
                doubts.tell(*place, format!("row {i}: `position_mm` is {}, {words}: does it sit on the shaft? rows count from 0", short(1e3 * row.position)));
            }
            let bore = design.size_mm[0];
            let own = self.bore_mm.as_ref();
            let own = own.map(|own| (r.place(own.span()), *own.get_ref()));
            if let (Some(bore), Some((place, own))) = (bore, own)
                && own / bore > *SEAT.start()
                && !told.contains(&place)
            {
                told.push(place);
                let message = format!(
                    "`bore_mm` of [shaft] is {own}, and the bore of row {i}'s bearing {bore}: is it that of the hollow shaft?"
                );
                doubts.tell(place, message);
            }
            let there = |section: &&Spanned<SectionKeys>| {
                let section = section.get_ref().section();
                (section.from..=section.to).contains(&row.position)
            };
            let outer = self.sections.iter().flatten().filter(there);
            let outer: Vec<_> = outer.map(|section| &section.get_ref().outer_mm).collect();
            // The shaft ends at the groove, at least, where the bore is not known.
            let groove = 1e3 * row.design.pitch_diameter;
            let fits = outer.iter().any(|outer| match bore {
                Some(bore) => SEAT.contains(&(outer.get_ref() / bore)),
                None => *outer.get_ref() < groove,
            });
            let outer = outer
                .first()
                .map(|outer| (r.place(outer.span()), outer.get_ref()));
            let outer = outer.filter(|(place, _)| !fits && !told.contains(place));
            if let Some((place, outer)) = outer {
                told.push(place);
                let (of, size) = bore.map_or(("pitch diameter", groove), |bore| ("bore", bore));
                let message = format!(
                    "`outer_mm` of the section at row {i} is {outer}, and the {of} of its bearing {}: is it the diameter?",
                    short(size)
                );
                doubts.tell(place, message);
            }
        }
    }
}

/// Shares of a bearing's bore that the diameter of the shaft in it mostly has. That of the shaft's own bore is less.
const SEAT: RangeInclusive<f64> = 0.8..=1.25;

const NO_RING: &str = "but must lie between 0 and the diameter of the inner groove of";

/// The bore, if that leaves some of the row's inner ring.
fn in_ring(row: &Row, bore: f64) -> Option<f64> {
    let growth = Growth::by_rotation(&row.design, bore, 1.0);
    growth.radial.is_finite().then_some(bore)
}
