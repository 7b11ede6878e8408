//! What a kind of record for glossy surfaces must know of itself. All else (filling, spacing, file, figures, command line)
//! goes over the list of kinds and knows none of them.

use super::file::{CacheFileError, Reader};
use super::policy::Finish;
use super::settings::Quality;
use super::site::Site;
use crate::bsdf::{Parts, Split};
use crate::cache::{Cache, Drawn, Lookup};
use crate::record::{Receiver, Record};
use crate::scene::Rgb;
use crate::scene::checksum::Hash;
use crate::world::Counts;
use brdf_tables::brdf::Specular;
use brdf_tables::material::Material as Recipe;
use brdf_tables::table::Table;
use core::fmt::Debug;
use glam::Vec3A;
use serde::Serialize;

/// A kind of record for glossy surfaces. A value of it holds what it knows of the materials of a scene.
pub trait GlossyKind: Clone + Debug + Default + Send + Sync {
    /// As typed after `--method`.
    const NAME: &'static str;
    /// What the method does, for its help.
    const ABOUT: &'static str;
    /// Key of the mean number of elements of a record in the figures of a run.
    const MEAN_KEY: &'static str;
    /// Whether it looks anything up in fitted tables.
    const TABLES: bool;
    /// Tells its sample points from those of other records.
    const SALT: u64;
    /// Whether surfaces that are read together take less time than one by one.
    const TOGETHER: bool;

    /// What a method that asks for it must tell besides.
    type Settings: Copy + Debug + PartialEq;
    /// What it keeps at a point.
    type Record: Record + Clone + Debug + 'static;
    /// How it holds a material.
    type Held: Copy + Debug + PartialEq + Serialize;
    /// Memory for reading records, used again from point to point.
    type Scratch: Default;

    /// Its own defaults at the tolerance τ.
    fn settings(tolerance: f32) -> Self::Settings;

    /// Notes how it is asked for; whether it takes part.
    fn ask(&mut self, asked: Asked<Self::Settings>) -> bool;

    /// Takes a specular part if it can hold it, and says in words what it does with it. `table` finds or fits a table.
    ///
    /// # Errors
    /// Those of `table`.
    fn hold<E>(
        &mut self,
        specular: Specular,
        table: &mut impl FnMut(&Recipe) -> Result<Table, E>,
    ) -> Result<(Option<Self::Held>, String), E>;

    /// What it does with a specular part where it pays ([`Asked::Paying`]), in words; `None` if it is never chosen so.
    fn outlook(specular: &Specular) -> Option<String>;

    /// Adds what its records were made for, to tell whether those of a file are the same: tables apart from all else.
    fn key(&self, tables: &mut Hash, method: &mut Hash);

    /// Width of the lobe of a material, radian.
    fn lobe_width(&self, held: Self::Held) -> f32;

    /// Whether records serve a view at all, whose direction to the eye is `wo` in the local frame.
    fn serves(&self, held: Self::Held, wo: Vec3A) -> bool;

    /// How far a record is fine enough, from 0 to 1, for a view whose mirror direction (world space) is this.
    fn trust(&self, _: Self::Held, _: &Self::Record, _: Vec3A) -> f32 {
        1.0
    }

    /// The record of a place, its radius set, and what it took.
    fn make(&self, held: Self::Held, site: &Site) -> Option<(Self::Record, Counts)>;

    /// What a record reflects at a point, diffuse part included: where records differ in that, they reach less far.
    fn light(
        &self,
        held: Self::Held,
        record: &Self::Record,
        parts: &Parts,
        at: &Receiver,
        quality: &Quality,
        scratch: &mut Self::Scratch,
    ) -> Rgb;

    /// What the records about a point reflect.
    fn reflect(
        &self,
        held: Self::Held,
        records: &impl Lookup<Self::Record>,
        at: &Shaded,
        quality: &Quality,
        scratch: &mut Self::Scratch,
    ) -> Found;

    /// What the records drawn onto a tile reflect at some of its surfaces, all held alike: what [`GlossyKind::reflect`] says of
    /// each, in their order, to the last bit.
    fn splat(
        &self,
        held: Self::Held,
        records: &Drawn<Self::Record>,
        surfaces: &[Shaded],
        quality: &Quality,
        scratch: &mut Self::Scratch,
    ) -> Vec<Found>;

    /// Appends a record to a file.
    fn write(record: &Self::Record, bytes: &mut Vec<u8>);

    /// Reads what [`GlossyKind::write`] wrote.
    ///
    /// # Errors
    /// Bytes that are no record.
    fn read(reader: &mut Reader) -> Result<Self::Record, CacheFileError>;

    /// The size of a record, in what it is made of: sources, bands.
    fn elements(record: &Self::Record) -> usize;

    /// Number and size of records in words.
    fn sentence(figures: &KindFigures) -> String;
}

/// How a method asks for a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked<S> {
    /// Not at all.
    No,
    /// Where it pays.
    Paying,
    /// Wherever it can hold a material.
    Everywhere(S),
}

/// A surface of a pixel, as records are read for it.
#[derive(Clone, Copy)]
pub struct Shaded<'a> {
    /// Mean position of its samples, the frame of their mean normal, the mean direction to the eye.
    pub at: Receiver,
    /// Normal of the hemisphere of records, which no texture bends.
    pub hemisphere: Vec3A,
    /// Which records serve it.
    pub finish: Finish,
    /// Colours, summed over the samples.
    pub parts: &'a Parts,
}

/// What records say of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Reflected light; `None` where no record reaches.
    pub light: Option<Split>,
    /// Share that is to be path traced instead.
    pub traced: f32,
    /// The part of it that is due to records which say little of this point; more paths are due then.
    pub doubt: f32,
}

impl Found {
    /// Nothing is known: all is traced.
    pub const NOTHING: Self = Self { light: None, traced: 1.0, doubt: 0.0 };
}

/// Records of a kind in a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KindFigures {
    /// Records.
    pub records: usize,
    /// What their size is counted in (sources, bands), over all records.
    pub elements: usize,
    /// Memory.
    pub bytes: usize,
}

impl KindFigures {
    /// Number and size of the records of a cache.
    pub fn new<K: GlossyKind>(cache: &Cache<K::Record>) -> Self {
        let records = cache.records();
        Self { records: records.len(), elements: records.iter().map(K::elements).sum(), bytes: cache.bytes() }
    }

    /// Mean number of elements of a record, 0 without records.
    pub fn mean(&self) -> f64 {
        self.elements as f64 / self.records.max(1) as f64
    }

    /// Mean bytes of a record, 0 without records.
    pub fn mean_bytes(&self) -> f64 {
        self.bytes as f64 / self.records.max(1) as f64
    }
}

impl core::iter::Sum for KindFigures {
    fn sum<I: Iterator<Item = Self>>(figures: I) -> Self {
        figures.fold(Self::default(), |a, b| Self {
            records: a.records + b.records,
            elements: a.elements + b.elements,
            bytes: a.bytes + b.bytes,
        })
    }
}
