//! Noses of a spindle file: points on the shaft by name, `[nose]` and `[nose.tool]`.

use crate::doubts::{Doubts, Extent};
use crate::plan::ShaftEnd;
use crate::reading::{DesignFileError, Key, POSITIONS, Place, Reading, millimetres};
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use std::fmt;
use toml::Spanned;

/// A point on the shaft with a name.
#[derive(Debug, Clone)]
pub struct Nose {
    /// Its name: that of the plain `[nose]` is `nose`.
    pub name: String,
    /// Position, and flexibility on a rigid shaft.
    pub end: ShaftEnd,
}

/// Name of the plain `[nose]`.
pub(crate) const PLAIN: &str = "nose";

/// Keys of a nose.
#[derive(serde::Deserialize, Default)]
#[serde(
    deny_unknown_fields,
    expecting = "`position_mm`, `radial_um_per_kn`, `axial_um_per_kn`, or a nose by name, such as [nose.tool]"
)]
struct EndKeys {
    position_mm: Key<f64>,
    radial_um_per_kn: Key<f64>,
    axial_um_per_kn: Key<f64>,
}

/// Keys of the plain nose, and noses by name.
#[derive(Default)]
pub(crate) struct NoseKeys {
    plain: Option<EndKeys>,
    named: Vec<(Spanned<String>, EndKeys)>,
}

// `serde(flatten)` would lose the places of the keys.
impl<'de> Deserialize<'de> for NoseKeys {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Keys;
        impl<'de> Visitor<'de> for Keys {
            type Value = NoseKeys;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a nose")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<NoseKeys, A::Error> {
                let mut keys = NoseKeys::default();
                while let Some(key) = map.next_key::<Spanned<String>>()? {
                    let name = &**key.get_ref();
                    if !["position_mm", "radial_um_per_kn", "axial_um_per_kn"].contains(&name) {
                        keys.named.push((key, map.next_value()?));
                        continue;
                    }
                    let plain = keys.plain.get_or_insert_default();
                    let value = Some(map.next_value()?);
                    match name {
                        "position_mm" => plain.position_mm = value,
                        "radial_um_per_kn" => plain.radial_um_per_kn = value,
                        _ => plain.axial_um_per_kn = value,
                    }
                }
                Ok(keys)
            }
        }
        deserializer.deserialize_map(Keys)
    }
}

impl EndKeys {
    fn read(
        self,
        r: Reading<'_>,
        name: &str,
        place: Place,
        (extent, doubts): (&Extent, &mut Doubts<'_>),
    ) -> Result<Nose, DesignFileError> {
        let table = match name {
            PLAIN => PLAIN.to_owned(),
            name => format!("{PLAIN}.{name}"),
        };
        if let Some(position) = &self.position_mm {
            r.within("position_mm", position, POSITIONS)?;
        }
        let at = self
            .position_mm
            .as_ref()
            .map_or(place, |said| r.place(said.span()));
        let position = r.needed((&table, place), "position_mm", "-60", self.position_mm)?;
        let mut end = ShaftEnd::rigid(millimetres(position));
        if extent.is_far(end.position) {
            let words = extent.words(end.position);
            doubts.tell(
                at,
                format!("`position_mm` of [{table}] is {position}, {words}: is it in mm?"),
            );
        }
        for (key, value, freedoms) in [
            ("axial_um_per_kn", self.axial_um_per_kn, 0..1),
            ("radial_um_per_kn", self.radial_um_per_kn, 1..3),
        ] {
            let Some(value) = value else { continue };
            if extent.is_drawn() {
                let message = format!(
                    "`{key}` is for a rigid shaft, and the `sections` of [shaft] bend; remove it, or draw this end as a section"
                );
                return Err(r.error(r.place(value.span()), message));
            }
            let said = *value.get_ref();
            if said < 0.0 {
                let message = format!("`{key}` is {said}, but must be 0 at least");
                return Err(r.error(r.place(value.span()), message));
            }
            for i in freedoms {
                end.flexibility[i] = said / 1e9;
            }
        }
        let name = name.to_owned();
        Ok(Nose { name, end })
    }
}

impl NoseKeys {
    /// The noses of the table at this place, the plain one first.
    pub fn read(
        self,
        r: Reading<'_>,
        table: Place,
        extent: &Extent,
        doubts: &mut Doubts<'_>,
    ) -> Result<Vec<Nose>, DesignFileError> {
        let mut noses = Vec::new();
        if self.plain.is_some() || self.named.is_empty() {
            let plain = self.plain.unwrap_or_default();
            noses.push(plain.read(r, PLAIN, table, (extent, &mut *doubts))?);
        }
        for (name, keys) in self.named {
            let (place, name) = (r.place(name.span()), name.into_inner());
            let is_plain = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
            if name.is_empty() || name == PLAIN || !name.chars().all(is_plain) {
                let message =
                    "the name of a nose has letters, digits, `-` and `_`, and is not `nose`";
                return Err(r.error(place, message));
            }
            noses.push(keys.read(r, &name, place, (extent, &mut *doubts))?);
        }
        Ok(noses)
    }
}
