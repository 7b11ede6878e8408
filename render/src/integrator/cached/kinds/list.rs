//! All that has a part for each kind of glossy records, made from their list.

/// A line: name of the field, type of the kind, and what a method that asks for it must tell besides, if anything.
macro_rules! kinds {
    ($($(#[$attribute:meta])* $name:ident: $Kind:ident $(($bound:ident: $settings:ty))?,)*) => {
        use super::kind::{Asked, GlossyKind, KindFigures};
        use crate::cache::Cache;
        use brdf_tables::brdf::Specular;
        use brdf_tables::material::Material as Recipe;
        use brdf_tables::table::Table;
        use glam::Vec3A;
        use serde::{Serialize, Serializer};

        $($(#[$attribute])* pub use $name::$Kind;)*

        /// What every kind knows of the materials of a scene.
        #[derive(Clone, Debug, Default)]
        pub struct Kinds {
            $($(#[$attribute])* #[doc = concat!("Materials of [`", stringify!($Kind), "`].")] pub $name: $Kind,)*
        }

        /// The caches of all kinds.
        #[derive(Clone, Debug)]
        pub struct GlossyCaches {
            $($(#[$attribute])* #[doc = concat!("Records of [`", stringify!($Kind), "`].")]
            pub $name: Cache<<$Kind as GlossyKind>::Record>,)*
        }

        /// Something of each kind.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct PerKind<T> {
            $($(#[$attribute])* #[doc = concat!("That of [`", stringify!($Kind), "`].")] pub $name: T,)*
        }

        /// Memory for reading records of any kind.
        #[derive(Default)]
        pub struct Scratches {
            $($(#[$attribute])* $name: <$Kind as GlossyKind>::Scratch,)*
        }

        /// The kind that holds a material, and how.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Glossy {
            $($(#[$attribute])* #[doc = concat!("Held by [`", stringify!($Kind), "`].")]
            $Kind(<$Kind as GlossyKind>::Held),)*
        }

        /// Which methods may be used.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Allowed {
            /// Irradiance records and path tracing.
            Irradiance,
            /// Glossy records where they pay.
            Auto,
            $($(#[$attribute])* #[doc = concat!("Records of [`", stringify!($Kind), "`] wherever they can hold a material.")]
            $Kind $(($settings))?,)*
        }

        $($(#[$attribute])*
        impl Listed for $Kind {
            #[allow(unused_variables, reason = "a kind without settings")]
            fn alone(tolerance: f32) -> Allowed {
                Allowed::$Kind $(({
                    let $bound: $settings = Self::settings(tolerance);
                    $bound
                }))?
            }
            fn of(kinds: &Kinds) -> &Self {
                &kinds.$name
            }
            fn held(glossy: Glossy) -> Option<Self::Held> {
                if let Glossy::$Kind(held) = glossy { Some(held) } else { None }
            }
            fn cache(caches: &GlossyCaches) -> &Cache<Self::Record> {
                &caches.$name
            }
            fn cache_mut(caches: &mut GlossyCaches) -> &mut Cache<Self::Record> {
                &mut caches.$name
            }
            fn scratch(scratches: &mut Scratches) -> &mut Self::Scratch {
                &mut scratches.$name
            }
            fn part<T>(parts: &PerKind<T>) -> &T {
                &parts.$name
            }
            fn part_mut<T>(parts: &mut PerKind<T>) -> &mut T {
                &mut parts.$name
            }
        })*

        /// Number of kinds.
        pub const COUNT: usize = [$($(#[$attribute])* stringify!($name)),*].len();

        /// What the kinds say of themselves.
        pub const KINDS: [Description; COUNT] = [$($(#[$attribute])* Description::of::<$Kind>()),*];

        /// Does something with every kind, in the order of the list.
        ///
        /// # Errors
        /// The first.
        pub fn each<E: EachKind>(each: &mut E) -> Result<(), E::Error> {
            $($(#[$attribute])* each.run::<$Kind>()?;)*
            Ok(())
        }

        impl Kinds {
            /// Which kinds are among what is allowed.
            pub(super) fn ask(&mut self, allowed: &Allowed) -> PerKind<bool> {
                PerKind {
                    $($(#[$attribute])* $name: self.$name.ask(match allowed {
                        Allowed::$Kind $(($bound))? => Asked::Everywhere(($(*$bound)?)),
                        Allowed::Auto => Asked::Paying,
                        _ => Asked::No,
                    }),)*
                }
            }

            /// The first kind, of those asked for, that holds a specular part, and what the last that was asked says of it.
            pub(super) fn hold<E>(
                &mut self,
                asked: &PerKind<bool>,
                specular: Specular,
                table: &mut impl FnMut(&Recipe) -> Result<Table, E>,
            ) -> Result<(Option<Glossy>, Option<String>), E> {
                let mut note = None;
                $($(#[$attribute])*
                if asked.$name {
                    let (held, said) = self.$name.hold(specular, table)?;
                    note = Some(said);
                    if let Some(held) = held {
                        return Ok((Some(Glossy::$Kind(held)), note));
                    }
                })*
                Ok((None, note))
            }
        }

        impl Glossy {
            /// Does something with the kind.
            #[inline(always)]
            pub fn with<W: WithKind>(self, kinds: &Kinds, with: W) -> W::Out {
                match self {
                    $($(#[$attribute])* Self::$Kind(held) => with.run(&kinds.$name, held),)*
                }
            }
        }

        /// As a variant of one enum with those of [`Treatment`](super::policy::Treatment), whose tags begin before these.
        impl Serialize for Glossy {
            fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                let mut tag = 0;
                $($(#[$attribute])* {
                    tag += 1;
                    if let Self::$Kind(held) = self {
                        return to.serialize_newtype_variant("Treatment", tag, stringify!($Kind), held);
                    }
                })*
                unreachable!("variant {tag} is none of the list")
            }
        }

        impl GlossyCaches {
            /// No records yet, for a scene with these corners.
            pub fn new(min: Vec3A, max: Vec3A) -> Self {
                Self { $($(#[$attribute])* $name: Cache::new(min, max),)* }
            }

            /// Number and size of the records.
            pub fn figures(&self) -> PerKind<KindFigures> {
                PerKind { $($(#[$attribute])* $name: KindFigures::new::<$Kind>(&self.$name),)* }
            }
        }

        impl<T> PerKind<T> {
            /// All, in the order of the list.
            pub fn iter(&self) -> core::array::IntoIter<&T, COUNT> {
                [$($(#[$attribute])* &self.$name),*].into_iter()
            }
        }
    };
}
pub(super) use kinds;
