//! The table of known RIB requests: the name of each, where it may stand, and whether it begins or ends a block.

use crate::table::requests;

/// The part of a stream in which a request may stand (RISpec sections 4 and 5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stands {
    /// Before `WorldBegin`: the request sets an option.
    BeforeWorld,
    /// Between `WorldBegin` and `WorldEnd`.
    InWorld,
    /// Anywhere in the stream.
    Anywhere,
}

/// Whether a request begins or ends a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bracket {
    /// The request begins a block.
    Opens,
    /// The request ends a block.
    Closes,
    /// The request neither begins nor ends a block.
    Alone,
}

/// A row of the table of requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Name of the request in the stream.
    pub name: &'static str,
    /// The part of the stream in which the request may stand.
    pub stands: Stands,
    /// Whether the request begins or ends a block.
    pub bracket: Bracket,
}

macro_rules! stands {
    (options) => {
        Stands::BeforeWorld
    };
    (world) => {
        Stands::InWorld
    };
    (any) => {
        Stands::Anywhere
    };
}

macro_rules! bracket {
    (opens) => {
        Bracket::Opens
    };
    (closes) => {
        Bracket::Closes
    };
    () => {
        Bracket::Alone
    };
}

macro_rules! names {
    ($(#[doc = $doc:literal] $name:ident [$stands:ident $($bracket:ident)?] $(=> $method:ident($($rest:tt)*))?;)*) => {
        /// A request that is known, named as in the stream.
        #[allow(non_camel_case_types)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Request {
            $(#[doc = $doc] $name),*
        }

        /// Every known request, in the table's order.
        pub const ROWS: &[Row] = &[
            $(Row { name: stringify!($name), stands: stands!($stands), bracket: bracket!($($bracket)?) }),*
        ];

        const ALL: &[Request] = &[$(Request::$name),*];
    };
}
requests!(names);

/// Slots of the hash table of names: twice as many as there are names, and a power of two.
const SLOTS: usize = 256;

/// For each slot, one more than the index in [`ROWS`]; 0 is empty. Names that fall on one slot take the next ones.
static TABLE: [u8; SLOTS] = {
    let mut table = [0; SLOTS];
    let mut k = 0;
    while k < ROWS.len() {
        let mut at = slot(ROWS[k].name.as_bytes());
        while table[at] != 0 {
            at = (at + 1) % SLOTS;
        }
        table[at] = k as u8 + 1;
        k += 1;
    }
    table
};

const fn slot(name: &[u8]) -> usize {
    let n = name.len();
    let letters = name[0] as usize + 7 * name[n / 2] as usize + 31 * name[n - 1] as usize;
    (letters + 57 * n) % SLOTS
}

impl Request {
    /// The request of a name.
    #[inline]
    pub(crate) fn named(name: &str) -> Option<Request> {
        if name.is_empty() {
            return None;
        }
        let mut at = slot(name.as_bytes());
        while TABLE[at] != 0 {
            let k = TABLE[at] as usize - 1;
            if ROWS[k].name == name {
                return Some(ALL[k]);
            }
            at = (at + 1) % SLOTS;
        }
        None
    }

    /// What the table says of it.
    pub(crate) fn row(self) -> &'static Row {
        &ROWS[self as usize]
    }

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        self.row().name
    }

    /// Whether it opens, parts or ends a condition.
    pub(crate) fn is_condition(self) -> bool {
        matches!(self, Request::IfBegin | Request::ElseIf | Request::Else | Request::IfEnd)
    }
}

/// The known name nearest to one that is not, if it is near enough to be a slip.
pub(crate) fn nearest(name: &str) -> Option<&'static str> {
    /// The most bytes of a name that is compared: none of ours is nearly as long.
    const MAX: usize = 64;
    if name.len() > MAX {
        return None;
    }
    let distance = |known: &&str| strsim::damerau_levenshtein(known, name);
    ROWS.iter().map(|row| row.name).min_by_key(distance).filter(|known| distance(known) <= 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_found_and_blocks_close() {
        for (k, row) in ROWS.iter().enumerate() {
            let found = Request::named(row.name).expect("a name of the table");
            assert_eq!((found as usize, found.name()), (k, row.name));
        }
        for name in ["", "Shpere", "sphere", "Sphere2", "WorldBegi"] {
            assert_eq!(Request::named(name), None, "{name}");
        }
        // A block's two requests have one name, but for its ending.
        for row in ROWS.iter().filter(|row| row.bracket != Bracket::Alone) {
            let (own, other) = if row.bracket == Bracket::Opens { ("Begin", "End") } else { ("End", "Begin") };
            let stem = row.name.strip_suffix(own).expect("named by its bracket");
            let partner = Request::named(&format!("{stem}{other}")).expect("both ends of a block").row();
            assert!(partner.bracket != Bracket::Alone && partner.bracket != row.bracket, "{}", row.name);
        }
        assert_eq!(nearest("Shpere"), Some("Sphere"));
        assert_eq!(nearest("nothing like it"), None);
        let stands = |name| Request::named(name).map(|r| r.row().stands);
        assert_eq!(stands("Sphere"), Some(Stands::InWorld));
        assert_eq!(stands("Format"), Some(Stands::BeforeWorld));
        assert_eq!(stands("Color"), Some(Stands::Anywhere));
    }
}
